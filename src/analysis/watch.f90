!> What a run watches at every step beside the error: models that are used outside their range. Floor: analysis.
module limber_analysis_watch
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_system_algebra, only: cross
   use limber_system_system, only: system_type
   implicit none
   private
   public :: check_deflections

contains

   !> An error if a beam deflects by more than its length: no frame can follow that, and mostly the motion diverges.
   subroutine check_deflections(system, t, q, v, error)
      type(system_type), intent(in) :: system
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Which beam, when, why and what to do
      type(error_type), allocatable, intent(out) :: error
      integer :: i, first, n
      real(wp) :: spin, first_frequency
      do i = 1, size(system%layout%n)
         n = system%layout%n(i)
         if (n == 0) cycle
         first = system%layout%q(i) + 4
         associate (body => system%model%bodies(i))
            if (maxval(abs(q(first:first + n - 1)))*body%largest_shape <= body%size) cycle
            spin = abs(cross(q(first - 2:first - 1), v(first - 2:first - 1)))
            first_frequency = sqrt(minval(body%reduced%omega2))
            if (.not. body%reduced%geometric .and. spin > first_frequency) then
               call raise(error, "beam '"//body%name//"' deflects by more than its length at t = "//as_text(t, 8)// &
                  & ': it diverges, for it rotates at '//as_text(spin, 3)//' rad/'//system%model%units%time// &
                  & ', above its first frequency '// &
                  & as_text(first_frequency, 3)//', and a LINEAR beam is not stiffened by the tension that rotation makes.'// &
                  & ' Use GEOMETRIC=K_G or FULL')
            else
               call raise(error, "beam '"//body%name//"' deflects by more than its length at t = "//as_text(t, 8)// &
                  & ': that is outside what one floating frame can describe, or the motion diverges. Look at the history up to'// &
                  & ' there, use GEOMETRIC=FULL, or divide the beam')
            end if
            return
         end associate
      end do
   end subroutine check_deflections

end module limber_analysis_watch
