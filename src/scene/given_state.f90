!> Changes of the given first state by the assembly. Which bodies, what it was and what it is. Floor: scene.
module limber_scene_given_state
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: change_type, changed_places, changed_velocities

   character(*), parameter :: names(6) = [character(5) :: 'X', 'Y', 'ANGLE', 'VX', 'VY', 'SPIN']
   real(wp), parameter :: turn = 2*acos(-1.0_wp)

   !> A body whose first state has changed
   type :: change_type
      integer :: body = 0
      !> Relative change, and 'ANGLE=0.5 becomes 0.411'
      real(wp) :: off = 0.0_wp
      character(:), allocatable :: text
   end type change_type

contains

   !> The bodies whose given place has changed by more than a little, relative to the scene or in radians, most first.
   subroutine changed_places(system, q, changes)
      type(system_type), intent(in) :: system
      !> Assembled coordinates (nq)
      real(wp), intent(in) :: q(:)
      type(change_type), allocatable, intent(out) :: changes(:)
      !> Change that is no more than a rounded number in the deck
      real(wp), parameter :: little = 1.0e-3_wp
      real(wp) :: old(3), new(3), change(3)
      integer :: i, first
      allocate (changes(0))
      do i = 1, size(system%layout%q)
         associate (given => system%model%bodies(i)%given(:3))
            if (.not. any(given)) cycle
            first = system%layout%q(i)
            old = [system%model%bodies(i)%position, system%model%bodies(i)%angle]
            new = [q(first:first + 1), old(3)]
            if (system%layout%framed(i)) new(3) = nearest_angle(old(3), atan2(q(first + 3), q(first + 2)))
            change = merge(abs(new - old), 0.0_wp, given)
            change(:2) = change(:2)/system%model%length
            if (size_of(change) > little) call insert(changes, i, change, old, new, names(:3))
         end associate
      end do
   end subroutine changed_places

   !> The same for velocities, relative to what is given, or to the fastest of the scene where that is little.
   subroutine changed_velocities(system, q, v, changes)
      type(system_type), intent(in) :: system
      !> Assembled coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      type(change_type), allocatable, intent(out) :: changes(:)
      !> Change without a word, part of the fastest velocity that counts as little
      real(wp), parameter :: little = 1.0e-2_wp, slow = 1.0e-2_wp
      real(wp) :: old(3), new(3), change(3), least(2), speed
      integer :: i, first
      allocate (changes(0))
      least = 0.0_wp
      do i = 1, size(system%layout%q)
         least(1) = max(least(1), norm2(system%model%bodies(i)%velocity))
         if (system%layout%framed(i)) least(2) = max(least(2), abs(system%model%bodies(i)%spin))
      end do
      least = slow*max(least, [least(2)*system%model%length, least(1)/system%model%length])
      do i = 1, size(system%layout%q)
         associate (given => system%model%bodies(i)%given(4:))
            if (.not. any(given)) cycle
            first = system%layout%q(i)
            old = [system%model%bodies(i)%velocity, system%model%bodies(i)%spin]
            new = [v(first:first + 1), 0.0_wp]
            if (system%layout%framed(i)) new(3) = cross(q(first + 2:first + 3), v(first + 2:first + 3))
            change = merge(abs(new - old), 0.0_wp, given)
            speed = max(least(1), norm2(old(:2)))
            if (speed > 0.0_wp) change(:2) = change(:2)/speed
            speed = max(least(2), abs(old(3)))
            if (speed > 0.0_wp) change(3) = change(3)/speed
            if (size_of(change) > little) call insert(changes, i, change, old, new, names(4:))
         end associate
      end do
   end subroutine changed_velocities

   !> Puts a change behind those that are as large.
   subroutine insert(changes, body, change, old, new, names)
      type(change_type), allocatable, intent(inout) :: changes(:)
      integer, intent(in) :: body
      !> Relative changes along x and y, of the angle; what was given, and what it is
      real(wp), intent(in) :: change(3), old(3), new(3)
      character(*), intent(in) :: names(3)
      !> Part of the largest change that is worth a word, and of what was given that is none
      real(wp), parameter :: share = 0.3_wp, round_off = 1.0e-12_wp
      type(change_type), allocatable :: longer(:)
      character(:), allocatable :: text
      integer :: i, k, place
      text = ''
      do k = 1, 3
         if (change(k) > share*size_of(change)) text = text//', '//trim(names(k))//'='//as_text(old(k), 5)//' becomes '// &
            & as_text(merge(0.0_wp, new(k), abs(new(k)) < round_off*abs(old(k))), 5)
      end do
      place = 1 + count(changes%off >= size_of(change))
      allocate (longer(size(changes) + 1))
      do i = 1, size(longer)
         if (i < place) longer(i) = changes(i)
         if (i > place) longer(i) = changes(i - 1)
      end do
      longer(place)%body = body
      longer(place)%off = size_of(change)
      longer(place)%text = text(3:)
      call move_alloc(longer, changes)
   end subroutine insert

   !> Size of a change of place and angle, the same whatever the directions of the axes.
   pure real(wp) function size_of(change)
      !> Along x and y, of the angle; each relative to its scale
      real(wp), intent(in) :: change(3)
      size_of = max(norm2(change(:2)), change(3))
   end function size_of

   !> The angle that differs from another one by whole turns and is nearest to a third.
   pure real(wp) function nearest_angle(goal, angle) result(near)
      real(wp), intent(in) :: goal, angle
      near = angle + turn*anint((goal - angle)/turn)
   end function nearest_angle

end module limber_scene_given_state
