!> Section forces of exact beams by equilibrium. All that acts behind a section, inertia and weight among it, in the axes of the
!> section; of taut beams at the place that the tension gives to what the functions lack. Floor: output. Source: doc/theory,
!> eqs. (2.46), (2.63)-(2.65), (7.54).
module limber_output_exact_forces
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type, reach_of, angles_at, lean_at, panel_stations
   use limber_beam_exact_profile, only: of_mass, of_rotary, of_ea, of_ei, of_ga
   use limber_beam_taut_axis, only: settled_type, settle_axis, added_moment, added_angle, tensions, is_taut, locate, &
      & fields_at, values_at, fields
   use limber_beam_force_recovery, only: recovery_type, section_type
   use limber_model_model, only: body_type
   use limber_multibody_plane_vectors, only: turn, cross
   use limber_multibody_beam_axis, only: centreline_type, inner
   implicit none
   private
   public :: section_reach_type, new_section_reach, inertia_behind, add_behind, turn_into_sections
   public :: settle_sections, settle_stations, find_lack

   !> Distance of places that are the same, of the length of the beam
   real(wp), parameter :: near = 1.0e-9_wp

   !> What belongs to the sections of a beam at any state, found once, and their places at the last one
   type :: section_reach_type
      !> What the stations give to the place of each section, and of each part of a load (stations, sections), (stations, parts)
      real(wp), allocatable :: reach(:, :), part(:, :)
      !> Functions of the angle (angles, sections), and the angle of the undeformed axis (sections)
      real(wp), allocatable :: psi(:, :), lean(:)
      !> Of a recovery that has the stations, too: the panel of each section (sections), and what its stations and the fields of the
      !> rotation give there (stations of a panel, sections), (fields, sections); where it is in the panel, -1 to 1 (sections)
      integer, allocatable :: panel(:)
      real(wp), allocatable :: value(:, :), field_value(:, :), within(:)
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
         if (recovery%axis > 0) call locate_sections(exact, recovery, at)
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

   !> Where sections are in the panels.
   pure subroutine locate_sections(exact, recovery, at)
      type(exact_type), intent(in) :: exact
      type(recovery_type), intent(in) :: recovery
      type(section_reach_type), intent(inout) :: at
      integer :: i
      associate (n => size(recovery%sections))
         allocate (at%panel(n), at%within(n), at%value(panel_stations, n), at%field_value(fields, n))
         do i = 1, n
            call locate(exact, recovery%sections(i)%x, recovery%sections(i)%behind, at%panel(i), at%within(i))
            at%value(:, i) = values_at(at%within(i))
            at%field_value(:, i) = fields_at(at%within(i))
         end do
      end associate
   end subroutine locate_sections

   !> Section forces of a taut beam, from those by equilibrium at the place of the functions: the moment with what the tension
   !> makes of the rotations that the functions lack, the others in the axes of sections that are turned so, eq. (2.65). At the
   !> ends moments stay those of the joints and loads, and all forces do where the section is held. Other beams keep what they
   !> have.
   pure subroutine settle_sections(body, sections, eta, rate, forces)
      type(body_type), intent(in) :: body
      type(section_reach_type), intent(in) :: sections
      !> Coordinates, and their rates (n)
      real(wp), intent(in) :: eta(:), rate(:)
      !> (3, sections), the last ones of which are the stations
      real(wp), intent(inout) :: forces(:, :)
      type(settled_type) :: turned, bent
      real(wp) :: tension(body%reduced%exact%stations), lack(3, body%reduced%exact%stations), axis(2), angle
      integer :: i
      associate (exact => body%reduced%exact, first => size(forces, 2) - body%reduced%exact%stations + 1)
         tension = tensions(exact, eta, forces(:, first:))
         if (.not. is_taut(tension)) return
         call find_lack(body, forces(:, first:), eta, rate, lack)
         call settle_axis(exact, lack(1, :), tension, held_angles(body), turned)
         call settle_axis(exact, lack(1, :), tension, [.false., .false.], bent)
      end associate
      do i = 1, size(forces, 2)
         associate (panel => sections%panel(i))
            angle = added_angle(turned, panel, sections%field_value(:, i))
            axis = [cos(angle), sin(angle)]
            forces(:, i) = [dot_product(axis, forces(1:2, i)), dot_product(turn(axis), forces(1:2, i)), &
               & forces(3, i) + added_moment(bent, panel, sections%within(i), sections%value(:, i))]
         end associate
      end do
   end subroutine settle_sections

   !> The same of the moments at the stations.
   pure subroutine settle_stations(body, eta, lack, forces)
      type(body_type), intent(in) :: body
      !> Coordinates (n); curvature that equilibrium asks for less that of the functions (stations)
      real(wp), intent(in) :: eta(:), lack(:)
      !> (3, stations)
      real(wp), intent(inout) :: forces(:, :)
      type(settled_type) :: bent
      real(wp) :: tension(body%reduced%exact%stations)
      associate (exact => body%reduced%exact)
         tension = tensions(exact, eta, forces)
         if (.not. is_taut(tension)) return
         call settle_axis(exact, lack, tension, [.false., .false.], bent)
      end associate
      forces(3, :) = forces(3, :) + bent%moment
   end subroutine settle_stations

   !> Whether the angles of the sections at the start and at the end are held.
   pure function held_angles(body) result(held)
      type(body_type), intent(in) :: body
      logical :: held(2)
      associate (support => body%choice%exact%support)
         held = [support%theta_start, support%theta_end]
      end associate
   end function held_angles

   !> Strains that equilibrium asks for less those that the functions make: curvature, stretch, shear, eq. (7.54).
   pure subroutine find_lack(body, forces, eta, rate, lack)
      type(body_type), intent(in) :: body
      !> Axial force, shear force, bending moment by equilibrium (3, stations)
      real(wp), intent(in) :: forces(:, :)
      !> Coordinates and their rates (n)
      real(wp), intent(in) :: eta(:), rate(:)
      !> (3, stations)
      real(wp), intent(out) :: lack(:, :)
      real(wp) :: strained(size(eta))
      integer :: k, a
      associate (exact => body%reduced%exact)
         a = exact%angles
         ! Damping makes moments, too
         strained = eta - exact%rest
         if (allocated(body%reduced%damping)) then
            if (size(body%reduced%damping, 1) == size(eta)) strained = strained &
               & + matmul(body%reduced%damping, rate)/body%reduced%omega2
         end if
         lack(3, :) = 0.0_wp
         do k = 1, exact%stations
            lack(1, k) = forces(3, k)/exact%section(of_ei, k) - dot_product(exact%kappa(:, k), strained(:a))
            lack(2, k) = forces(1, k)/exact%section(of_ea, k) - dot_product(exact%chi(1, :, k), strained(a + 1:))
            if (exact%shears > 0) lack(3, k) = forces(2, k)/exact%section(of_ga, k) &
               & - dot_product(exact%chi(2, :, k), strained(a + 1:))
         end do
      end associate
   end subroutine find_lack

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
