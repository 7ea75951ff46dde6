!> Laws with a kink or jump at the state of a modal analysis. There are no small vibrations with one stiffness and one damping. Each
!> mode is gone along a little to both sides, and the slopes of each law are compared. Floor: analysis. Source: doc/theory, eq.
!> (7.53).
module limber_analysis_kinks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_multibody_kinematics, only: kinematics_type, place_frames, move_frames
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_motion_laws, only: watched_loads, describe_law
   use limber_multibody_system, only: system_type
   use limber_multibody_tangent, only: tangent_type
   use limber_multibody_small_vibrations, only: vibrations_type
   implicit none
   private
   public :: kink_warnings

   !> Displacement of a mode that is gone to each side, relative to the length of the scene; the part of it that is gone once more
   real(wp), parameter :: little = 1.0e-6_wp, part = 1.0_wp/16
   !> Difference of both slopes relative to the larger one, and to the stiffness or damping of the mode, below which it is none
   real(wp), parameter :: equal = 0.05_wp, harmless = 0.01_wp

contains

   !> Warnings, one for each law that bends, of the lowest mode that shows it; empty if there is none.
   function kink_warnings(system, tangent, kinematics, t, q, v, is_damped, vibrations, name) result(text)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> Room, placed and moved in the state
      type(kinematics_type), intent(in) :: kinematics
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Whether damping counts
      logical, intent(in) :: is_damped
      type(vibrations_type), intent(in) :: vibrations
      !> Of the analysis
      character(*), intent(in) :: name
      character(:), allocatable :: text
      type(kinematics_type) :: room
      integer, allocatable :: laws(:)
      real(wp) :: side(2), finer(2), own, omega, size_of
      integer :: i, j, by_rate
      logical :: told
      text = ''
      laws = watched_loads(system)
      if (size(laws) == 0) return
      room = kinematics
      do i = 1, size(laws)
         told = .false.
         do j = 1, size(vibrations%frequency)
            associate (shape => real(vibrations%shape(:, j), wp))
               omega = sqrt(vibrations%frequency(j)**2 + vibrations%growth(j)**2)
               size_of = extent(system, shape)
               if (.not. size_of > 0.0_wp) cycle
               do by_rate = 0, merge(1, 0, is_damped)
                  side = slopes(little*system%model%length/size_of)
                  if (.not. abs(side(1) - side(2)) > equal*maxval(abs(side))) cycle
                  finer = slopes(part*little*system%model%length/size_of)
                  if (.not. abs(finer(1) - finer(2)) > 0.5_wp*abs(side(1) - side(2))) cycle
                  if (.not. abs(finer(1) - finer(2)) > harmless*max(omega**2, maxval(abs(finer)))) cycle
                  own = tangent_of(tangent, laws(i), shape, by_rate == 1)
                  if (by_rate == 1) own = own*omega
                  text = text//'warning: mode '//as_text(j)//" of *MODES '"//name//"': "//told_words(finer, &
                     & abs(finer(1) - finer(2)) > 4*abs(side(1) - side(2)))//newline
                  told = .true.
               end do
            end associate
            if (told) exit
         end do
      end do

   contains

      !> Work of the law on the shape for a unit of it, to both sides; of its rates as if it moved with the frequency.
      function slopes(step) result(slope)
         real(wp), intent(in) :: step
         real(wp) :: slope(2)
         real(wp) :: here
         here = work_of(0.0_wp)
         slope = [(here - work_of(step))/step, (work_of(-step) - here)/step]
      end function slopes

      !> Work of the law on the shape at a place beside the state.
      real(wp) function work_of(step) result(work)
         real(wp), intent(in) :: step
         real(wp) :: moved(size(q)), rate(size(v))
         real(wp) :: force(size(tangent%loads(laws(i))%unknowns))
         integer :: k
         moved = q
         rate = v
         associate (shape => real(vibrations%shape(:, j), wp))
            if (by_rate == 0) call advance(system%layout, q, step*shape, moved)
            if (by_rate == 1) then
               call velocities_of(system%layout, q, step*omega*shape, rate)
               rate = rate + v
            end if
            call place_frames(system%model, system%layout, t, moved, room)
            call move_frames(system%model, system%layout, moved, rate, room)
            force = 0.0_wp
            call system%loads(laws(i))%item%add_force(room, force)
            work = 0.0_wp
            do k = 1, size(force)
               work = work + force(k)*shape(tangent%loads(laws(i))%unknowns(k))
            end do
         end associate
      end function work_of

      !> Cause, both values, remedy.
      function told_words(slope, jumps) result(words)
         real(wp), intent(in) :: slope(2)
         logical, intent(in) :: jumps
         character(:), allocatable :: words
         real(wp) :: value(2)
         words = describe_law(system, laws(i))
         if (jumps) then
            words = words//' jumps in this state, where there is no small vibration'
         else if (by_rate == 0) then
            value = vibrations%frequency(j)**2 + vibrations%growth(j)**2 - own + slope
            if (.not. vibrations%frequency(j) > 0.0_wp) value = -vibrations%growth(j)**2 - own + slope
            words = words//' bends in this state: with its slope to one side the frequency is '//frequency(value(1))// &
               & ', with that to the other '//frequency(value(2))//', and *MODES takes one of them'
         else
            value = -vibrations%growth(j) + 0.5_wp*(slope - own)/omega
            words = words//' bends in this state: with its slope to one side the damping ratio is '// &
               & as_text(value(1)/omega, 3)//', with that to the other '//as_text(value(2)/omega, 3)// &
               & ', and *MODES takes one of them'
         end if
         words = words//'; go off the bend by *STATICS or other first positions, or find the vibration by *DYNAMICS'
      end function told_words

      !> A frequency from its square.
      function frequency(square) result(words)
         real(wp), intent(in) :: square
         character(:), allocatable :: words
         words = as_text(sqrt(max(0.0_wp, square)), 4)//' rad/'//system%model%units%time
         if (square < 0.0_wp) words = 'none, it grows,'
      end function frequency

   end function kink_warnings

   !> Largest displacement of a shape, rotations times the length of the scene [length].
   pure real(wp) function extent(system, shape) result(largest)
      type(system_type), intent(in) :: system
      !> In the layout of the rates (nw)
      real(wp), intent(in) :: shape(:)
      integer :: i, first, n
      largest = 0.0_wp
      do i = 1, size(system%layout%w)
         first = system%layout%w(i)
         n = system%layout%n(i)
         largest = max(largest, maxval(abs(shape(first:first + 1))))
         if (.not. system%layout%framed(i)) cycle
         largest = max(largest, abs(shape(first + 2))*system%model%length)
         if (n > 0) largest = max(largest, maxval(abs(shape(first + 3:first + 2 + n)))*system%model%bodies(i)%largest_shape)
      end do
   end function extent

   !> Stiffness or damping of a mode by the law as the analysis has it.
   pure real(wp) function tangent_of(tangent, load, shape, by_rate) result(own)
      type(tangent_type), intent(in) :: tangent
      integer, intent(in) :: load
      real(wp), intent(in) :: shape(:)
      logical, intent(in) :: by_rate
      associate (of => tangent%loads(load))
         if (by_rate) own = dot_product(shape(of%unknowns), matmul(of%damping, shape(of%unknowns)))
         if (.not. by_rate) own = dot_product(shape(of%unknowns), matmul(of%stiffness, shape(of%unknowns)))
      end associate
   end function tangent_of

end module limber_analysis_kinks
