!> Instants at which a law of time changes its formula: where min, max, abs, step or smoothstep turn from one branch to
!> another. An integrator ends a step there and starts anew. Floor: model.
module limber_model_breaks
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_model_scene, only: model_type
   implicit none
   private
   public :: break_times, law_breaks

   !> Equal parts of the time that are looked at: a formula that comes and goes within one of them is not seen
   integer, parameter :: parts = 500
   !> Part of the whole time within which two breaks are one
   real(wp), parameter :: apart = 1.0e-12_wp
   !> Most breaks of one model: beyond them a law is taken for noise, which no step can follow
   integer, parameter :: most = 1000

contains

   !> The instants of all drivers and loads of a model within its dynamic analysis, in order, each once.
   function break_times(model) result(times)
      type(model_type), intent(in) :: model
      real(wp), allocatable :: times(:)
      integer :: i, j
      allocate (times(0))
      associate (t0 => model%dynamics%start, t1 => model%dynamics%end)
         do i = 1, size(model%drivers)
            call law_breaks(model%drivers(i)%law, t0, t1, times)
         end do
         do i = 1, size(model%joints)
            if (model%joints(i)%has_law) call law_breaks(model%joints(i)%law, t0, t1, times)
         end do
         do i = 1, size(model%forces)
            do j = 1, 2
               call law_breaks(model%forces(i)%law(j), t0, t1, times)
            end do
         end do
         do i = 1, size(model%torques)
            call law_breaks(model%torques(i)%law, t0, t1, times)
         end do
         do i = 1, size(model%efforts)
            if (.not. model%efforts(i)%driven) cycle
            if (all(model%efforts(i)%quantities%kind == 0)) call law_breaks(model%efforts(i)%law, t0, t1, times)
         end do
      end associate
   end function break_times

   !> Adds the instants of one law to a list in order.
   subroutine law_breaks(law, start, end, times)
      type(expression_type), intent(in) :: law
      !> First and last time; breaks at these two do not count
      real(wp), intent(in) :: start, end
      real(wp), allocatable, intent(inout) :: times(:)
      real(wp) :: left, right, found
      integer :: part
      if (law%branches(start) < 0) return
      right = start
      do part = 1, parts
         left = right
         right = start + (end - start)*(real(part, wp)/parts)
         do while (law%branches(left) /= law%branches(right) .and. size(times) < most)
            found = first_change(law, left, right)
            if (min(found - start, end - found) > apart*(end - start)) call insert(found, apart*(end - start), times)
            left = found
            if (left >= right) exit
         end do
      end do
   end subroutine law_breaks

   !> The first instant of the branch that follows that of `left`, to the bit, by bisection.
   real(wp) function first_change(law, left, right) result(found)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: left, right
      real(wp) :: before, middle
      before = left
      found = right
      do
         middle = before + 0.5_wp*(found - before)
         if (middle <= before .or. middle >= found) return
         if (law%branches(middle) == law%branches(left)) then
            before = middle
         else
            found = middle
         end if
      end do
   end function first_change

   !> Puts a time into a list in order, unless it is there already.
   subroutine insert(t, width, times)
      real(wp), intent(in) :: t, width
      real(wp), allocatable, intent(inout) :: times(:)
      if (any(abs(times - t) <= width)) return
      times = [pack(times, times < t), t, pack(times, times > t)]
   end subroutine insert

end module limber_model_breaks
