!> Section forces of exact beams by equilibrium. All that acts behind a section, inertia and weight among it, in the axes of the
!> section. Floor: output. Source: doc/theory, eq. (2.46).
module limber_output_exact_forces
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type, reach_of, angles_at, lean_at
   use limber_beam_exact_profile, only: of_mass, of_rotary
   use limber_beam_force_recovery, only: recovery_type, section_type
   use limber_multibody_plane_vectors, only: turn, cross
   use limber_multibody_beam_axis, only: centreline_type, inner
   implicit none
   private
   public :: section_reach_type, new_section_reach, inertia_behind, add_behind, turn_into_sections

   !> Distance of places that are the same, of the length of the beam
   real(wp), parameter :: near = 1.0e-9_wp

   !> What belongs to the sections of a beam at any state, found once, and their places at the last one
   type :: section_reach_type
      !> What the stations give to the place of each section, and of each part of a load (stations, sections), (stations, parts)
      real(wp), allocatable :: reach(:, :), part(:, :)
      !> Functions of the angle (angles, sections), and the angle of the undeformed axis (sections)
      real(wp), allocatable :: psi(:, :), lean(:)
      !> In the axes of the frame (2, sections)
      real(wp), allocatable :: place(:, :)
      !> Scratch: a field (stations, 2), accelerations (points, 2)
      real(wp), allocatable :: field(:, :), push(:, :)
   end type section_reach_type

contains

   !> The sections of a recovery.
   pure function new_section_reach(exact, recovery) result(at)
      type(exact_type), intent(in) :: exact
      type(recovery_type), intent(in) :: recovery
      type(section_reach_type) :: at
      integer :: i
      associate (n => size(recovery%sections), parts => size(recovery%part_at))
         allocate (at%reach(exact%stations, n), at%part(exact%stations, parts), at%psi(exact%angles, n), at%lean(n), at%place(2, n))
         do i = 1, n
            at%reach(:, i) = reach_of(exact, recovery%sections(i)%x) - exact%base
            at%psi(:, i) = angles_at(exact, recovery%sections(i)%x)
            at%lean(i) = lean_at(exact, recovery%sections(i)%x)
         end do
         do i = 1, parts
            at%part(:, i) = reach_of(exact, recovery%part_at(i)) - exact%base
         end do
      end associate
      at%place = 0.0_wp
      allocate (at%field(exact%stations, 2), at%push(exact%points, 2))
      at%field = 0.0_wp
      at%push = 0.0_wp
   end function new_section_reach

   !> What inertia and weight make at each section: force along the axes of the frame (2) and couple (3, sections). Places the
   !> sections.
   subroutine inertia_behind(line, recovery, sections, heavy, omega, alpha, eta_acceleration, forces)
      !> At the state
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      type(section_reach_type), intent(inout) :: sections
      !> Acceleration of the frame's origin less that of gravity, in the axes of the frame (2); angular velocity and acceleration;
      !> second derivatives of the coordinates (n)
      real(wp), intent(in) :: heavy(2), omega, alpha, eta_acceleration(:)
      real(wp), intent(out) :: forces(:, :)
      real(wp) :: f(2), place(2), part, swing
      integer :: i, k
      call line%accelerations(heavy, omega, alpha, eta_acceleration, sections%field, sections%push)
      do i = 1, size(recovery%sections)
         forces(:, i) = 0.0_wp
         place = place_of(line, sections%reach(:, i))
         sections%place(:, i) = place
         do k = 1, line%stations
            part = line%weight(k) - line%base(k) - sections%reach(k, i)
            f = -line%section(of_mass, k)*part*sections%push(k, :)
            forces(1:2, i) = forces(1:2, i) + f
            forces(3, i) = forces(3, i) + cross(line%p(k, :) - place, f)
            if (.not. line%inertia(k) > 0.0_wp) cycle
            swing = alpha + dot_product(line%psi(:, k), eta_acceleration(:line%angles))
            forces(3, i) = forces(3, i) - line%section(of_rotary, k)*part*swing
         end do
         do k = line%stations + 1, line%points
            associate (at => line%lump_at(k - line%stations))
               if (.not. is_behind(line%exact_type, recovery%sections(i), at)) cycle
               f = -line%mass(k)*sections%push(k, :)
               swing = alpha + dot_product(angles_at(line%exact_type, at), eta_acceleration(:line%angles))
               forces(1:2, i) = forces(1:2, i) + f
               forces(3, i) = forces(3, i) + cross(line%p(k, :) - place, f) - line%inertia(k)*swing
            end associate
         end do
      end do
   end subroutine inertia_behind

   !> Adds a force along the axes of the frame (2) and a couple at a coordinate along the beam; `inertia_behind` comes first.
   pure subroutine add_behind(line, recovery, sections, x, force, forces, reach)
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      type(section_reach_type), intent(in) :: sections
      real(wp), intent(in) :: x, force(3)
      real(wp), intent(inout) :: forces(:, :)
      !> What the stations give to the place of that coordinate, if it is known (stations)
      real(wp), contiguous, intent(in), optional :: reach(:)
      real(wp) :: place(2)
      integer :: i
      if (.not. any(abs(force) > 0.0_wp)) return
      if (present(reach)) then
         place = place_of(line, reach)
      else
         place = place_of(line, reach_of(line%exact_type, x) - line%base)
      end if
      do i = 1, size(recovery%sections)
         if (.not. is_behind(line%exact_type, recovery%sections(i), x)) cycle
         forces(1:2, i) = forces(1:2, i) + force(1:2)
         forces(3, i) = forces(3, i) + force(3) + cross(place - sections%place(:, i), force(1:2))
      end do
   end subroutine add_behind

   !> Axial force, shear force and bending moment of the sections, in the place of forces along the axes of the frame.
   subroutine turn_into_sections(sections, eta, forces)
      type(section_reach_type), intent(in) :: sections
      real(wp), intent(in) :: eta(:)
      real(wp), intent(inout) :: forces(:, :)
      real(wp) :: angle, axis(2)
      integer :: i
      do i = 1, size(sections%lean)
         angle = sections%lean(i) + dot_product(sections%psi(:, i), eta(:size(sections%psi, 1)))
         axis = [cos(angle), sin(angle)]
         forces(1:2, i) = [dot_product(axis, forces(1:2, i)), dot_product(turn(axis), forces(1:2, i))]
      end do
   end subroutine turn_into_sections

   !> Whether a place lies behind a section.
   pure logical function is_behind(exact, section, x)
      type(exact_type), intent(in) :: exact
      type(section_type), intent(in) :: section
      real(wp), intent(in) :: x
      if (section%behind) then
         is_behind = x > section%x + near*exact%total
      else
         is_behind = x > section%x - near*exact%total
      end if
   end function is_behind

   !> Place with a reach, in the axes of the frame (2).
   pure function place_of(line, reach) result(place)
      type(centreline_type), intent(in) :: line
      !> (stations)
      real(wp), contiguous, intent(in) :: reach(:)
      real(wp) :: place(2)
      place = [inner(line%stations, reach, line%g(:, 1)), inner(line%stations, reach, line%g(:, 2))]
   end function place_of

end module limber_output_exact_forces
