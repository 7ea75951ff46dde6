!> Internal forces of exact beams by equilibrium: all that acts behind a section, inertia and weight among it, in the axes of the
!> section. Floor: output. Source: doc/theory, eq. (X12).
module limber_output_exact_forces
   use limber_base_kinds, only: wp
   use limber_flex_exact, only: exact_type, reach_of, angles_at, lean_at
   use limber_flex_exact_profile, only: of_mass, of_rotary
   use limber_flex_recovery, only: recovery_type, section_type
   use limber_system_algebra, only: turn, cross
   use limber_system_centreline, only: centreline_type
   implicit none
   private
   public :: inertia_behind, add_behind, turn_into_sections

   !> Distance of places that are the same, of the length of the beam
   real(wp), parameter :: near = 1.0e-9_wp

contains

   !> What inertia and weight make at each section: force along the axes of the frame (2) and couple (3, sections).
   subroutine inertia_behind(line, recovery, heavy, omega, alpha, eta_acceleration, forces)
      !> At the state
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      !> Acceleration of the frame's origin less that of gravity, in the axes of the frame (2); angular velocity and acceleration;
      !> second derivatives of the coordinates (n)
      real(wp), intent(in) :: heavy(2), omega, alpha, eta_acceleration(:)
      real(wp), intent(out) :: forces(:, :)
      real(wp) :: push(line%points, 2), part(line%stations), f(2), place(2), swing
      integer :: i, k
      call line%accelerations(heavy, omega, alpha, eta_acceleration, push)
      do i = 1, size(recovery%sections)
         forces(:, i) = 0.0_wp
         place = place_of(line, recovery%sections(i)%x)
         part = line%weight - reach_of(line%exact_type, recovery%sections(i)%x)
         do k = 1, line%stations
            f = -line%section(of_mass, k)*part(k)*push(k, :)
            forces(1:2, i) = forces(1:2, i) + f
            forces(3, i) = forces(3, i) + cross(line%p(k, :) - place, f)
            if (.not. line%inertia(k) > 0.0_wp) cycle
            swing = alpha + dot_product(line%psi(:, k), eta_acceleration(:line%angles))
            forces(3, i) = forces(3, i) - line%section(of_rotary, k)*part(k)*swing
         end do
         do k = line%stations + 1, line%points
            associate (at => line%lump_at(k - line%stations))
               if (.not. is_behind(line%exact_type, recovery%sections(i), at)) cycle
               f = -line%mass(k)*push(k, :)
               swing = alpha + dot_product(angles_at(line%exact_type, at), eta_acceleration(:line%angles))
               forces(1:2, i) = forces(1:2, i) + f
               forces(3, i) = forces(3, i) + cross(line%p(k, :) - place, f) - line%inertia(k)*swing
            end associate
         end do
      end do
   end subroutine inertia_behind

   !> Adds a force along the axes of the frame (2) and a couple at a coordinate along the beam.
   pure subroutine add_behind(line, recovery, x, force, forces)
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      real(wp), intent(in) :: x, force(3)
      real(wp), intent(inout) :: forces(:, :)
      real(wp) :: place(2)
      integer :: i
      place = place_of(line, x)
      do i = 1, size(recovery%sections)
         if (.not. is_behind(line%exact_type, recovery%sections(i), x)) cycle
         forces(1:2, i) = forces(1:2, i) + force(1:2)
         forces(3, i) = forces(3, i) + force(3) + cross(place - place_of(line, recovery%sections(i)%x), force(1:2))
      end do
   end subroutine add_behind

   !> Axial force, shear force and bending moment of the sections, in the place of forces along the axes of the frame.
   subroutine turn_into_sections(line, recovery, eta, forces)
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      real(wp), intent(in) :: eta(:)
      real(wp), intent(inout) :: forces(:, :)
      real(wp) :: angle, axis(2)
      integer :: i
      do i = 1, size(recovery%sections)
         angle = lean_at(line%exact_type, recovery%sections(i)%x) &
            & + dot_product(angles_at(line%exact_type, recovery%sections(i)%x), eta(:line%angles))
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

   !> Place of a coordinate along the beam, in the axes of the frame (2).
   pure function place_of(line, x) result(place)
      type(centreline_type), intent(in) :: line
      real(wp), intent(in) :: x
      real(wp) :: place(2), reach(line%stations)
      integer :: k
      reach = reach_of(line%exact_type, x) - line%base
      place = 0.0_wp
      do k = 1, line%stations
         place = place + reach(k)*line%g(k, :)
      end do
   end function place_of

end module limber_output_exact_forces
