!> Section forces of flexible bodies at a sample. Gathers what acts on a body, joint reactions among it, and lets the coefficients
!> of `limber_beam_force_recovery` turn it into axial force, shear force and bending moment. Floor: output. Source: doc/theory, eqs.
!> (2.24)-(2.26), (2.28).
module limber_output_internal_forces
   use limber_base_kinds, only: wp
   use limber_output_exact_forces, only: section_reach_type, new_section_reach, inertia_behind, add_behind, turn_into_sections, &
      & settle_sections
   use limber_output_point_forces, only: pull_type, pulls_type, new_pulls, constraint_pulls, load_pulls, most_pulls
   use limber_beam_exact_profile, only: profile_at, profile_values
   use limber_beam_force_recovery, only: recovery_type, section_type, amplitudes, geometric_state, internal_forces
   use limber_model_model, only: body_type, ground
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_beam_axis, only: centreline_type
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_constraint, only: constraint_type
   use limber_multibody_sliding_along_beam, only: exact_path_type, foot_of
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: renew_efforts
   public :: section_forces_type, new_efforts, start_effort, hold_efforts, gather_efforts, gather_exact, gather_modal, &
      & join_envelopes, &
      & section_forces, &
      & stresses, strength_at

   !> What acts on one body that has sections; none otherwise
   type :: section_forces_type
      !> (columns of its recovery)
      real(wp), allocatable :: amplitude(:)
      !> Place of each point of the model among those of the body; 0: none of them (points)
      integer, allocatable :: place(:)
      !> Forces of one load (rates)
      real(wp), allocatable :: scratch(:)
      !> What acts on several points of a body
      type(pulls_type) :: pulls
      !> Of an envelope: least and greatest axial force, shear force, bending moment, and stresses to the left and to the right
      !> (5, 2, sections along the body); otherwise unallocated
      real(wp), allocatable :: extremes(:, :, :)
      !> Of an exact beam: internal forces at its sections (3, sections), otherwise unallocated; and where they are
      real(wp), allocatable :: exact(:, :)
      type(section_reach_type) :: sections
      !> What acts on its frame, which is the section at the origin: force and couple in the axes of the frame
      real(wp) :: on_frame(3) = 0.0_wp
      !> Coordinates that a body with modes would have to have besides for its forces: where its deflections are held to carry what
      !> acts, and for those of its damping (n); otherwise unallocated
      real(wp), allocatable :: lacking(:)
      !> Whether its deflections are held
      logical :: held = .false.
      !> Where tension acts on the bending: what the geometric forces make at its sections (4, sections); otherwise unallocated
      real(wp), allocatable :: geometric(:, :)
   end type section_forces_type

contains

   !> Room for all bodies.
   function new_efforts(system) result(efforts)
      type(system_type), intent(in) :: system
      type(section_forces_type), allocatable :: efforts(:)
      integer :: i
      allocate (efforts(size(system%model%bodies)))
      do i = 1, size(efforts)
         if (.not. allocated(system%model%bodies(i)%recovery%load)) cycle
         call start_effort(efforts(i), system, i, system%model%bodies(i)%recovery)
         associate (body => system%model%bodies(i))
            if (body%envelope) then
               allocate (efforts(i)%extremes(5, 2, size(body%recovery%load, 3) - body%recovery%axis &
                  & - body%point_sections))
               efforts(i)%extremes(:, 1, :) = huge(1.0_wp)
               efforts(i)%extremes(:, 2, :) = -huge(1.0_wp)
            end if
         end associate
      end do
   end function new_efforts

   !> Takes note of joints, drivers and loads that act since a switch was turned.
   subroutine renew_efforts(efforts, system)
      type(section_forces_type), intent(inout) :: efforts(:)
      type(system_type), intent(in) :: system
      integer :: i
      do i = 1, size(efforts)
         if (allocated(efforts(i)%place)) efforts(i)%pulls = new_pulls(system)
      end do
   end subroutine renew_efforts

   !> What acts on one body: nothing yet.
   subroutine start_effort(effort, system, body, recovery)
      type(section_forces_type), intent(out) :: effort
      type(system_type), intent(in) :: system
      !> Index of the body
      integer, intent(in) :: body
      !> Its sections
      type(recovery_type), intent(in) :: recovery
      integer :: i, most, count
      most = 0
      do i = 1, size(system%loads)
         most = max(most, sum(system%loads(i)%item%rates))
      end do
      allocate (effort%amplitude(size(recovery%load, 2)), effort%place(size(system%model%points)), effort%scratch(most))
      effort%amplitude = 0.0_wp
      effort%pulls = new_pulls(system)
      if (allocated(recovery%tension)) allocate (effort%geometric(4, size(recovery%sections)))
      if (system%model%bodies(body)%reduced%is_exact) then
         allocate (effort%exact(3, size(recovery%sections)))
         effort%sections = new_section_reach(system%model%bodies(body)%reduced%exact, recovery)
      end if
      effort%place = 0
      count = 0
      do i = 1, size(system%model%points)
         if (system%model%points(i)%body /= body .or. system%model%points(i)%member == 0) cycle
         ! Behind the points of the model stand directions that the system made of them
         if (count == recovery%places) exit
         count = count + 1
         effort%place(i) = count
      end do
   end subroutine start_effort

   !> The state that comes has its deflections held: what these would have to be besides to carry what acts, eq. (2.27).
   pure subroutine hold_efforts(efforts, system, motion)
      type(section_forces_type), intent(inout) :: efforts(:)
      type(system_type), intent(in) :: system
      !> Residual of the equations of motion (nw)
      real(wp), intent(in) :: motion(:)
      integer :: i, from
      do i = 1, size(efforts)
         if (.not. allocated(efforts(i)%amplitude) .or. allocated(efforts(i)%exact)) cycle
         from = system%layout%w(i) + system%layout%rates(i)
         efforts(i)%held = .true.
         efforts(i)%lacking = -motion(from:from + system%layout%n(i) - 1)/system%model%bodies(i)%reduced%omega2
      end do
   end subroutine hold_efforts

   !> Amplitudes of all bodies that have sections; multipliers, Jacobians and kinematics are those of the state.
   subroutine gather_efforts(efforts, system, work, q, v, a)
      type(section_forces_type), intent(inout) :: efforts(:)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      integer :: i, first, last
      do i = 1, size(efforts)
         if (.not. allocated(efforts(i)%amplitude)) cycle
         first = system%layout%q(i) + 4
         last = first - 1 + system%layout%n(i)
         if (allocated(efforts(i)%exact)) then
            call gather_exact(efforts(i), system, work, i, system%model%bodies(i)%recovery, q, v, a)
            call settle_sections(system%model%bodies(i), efforts(i)%sections, q(first:last), v(first:last), efforts(i)%exact)
         else
            call gather_modal(efforts(i), system, work, i, q, v, a)
         end if
         if (allocated(efforts(i)%extremes)) call stretch_envelope(efforts(i), system, i, q(first:last))
      end do
   end subroutine gather_efforts

   !> Amplitudes of a body with modes; multipliers, Jacobians and kinematics are those of the state.
   subroutine gather_modal(effort, system, work, body, q, v, a)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      real(wp) :: heavy(2)
      integer :: first, last
      first = system%layout%q(body)
      last = first + 3 + system%layout%n(body)
      heavy = a(first:first + 1) - system%model%gravity
      associate (u => q(first + 2:first + 3), eta => q(first + 4:last), rate => v(first + 4:last), &
         & of => system%model%bodies(body))
         heavy = [dot_product(u, heavy), cross(u, heavy)]
         if (allocated(of%reduced%damping) .and. .not. effort%held) effort%lacking = matmul(of%reduced%damping, rate) &
            & /of%reduced%omega2
         effort%amplitude = 0.0_wp
         call amplitudes(heavy, cross(u, v(first + 2:first + 3)), cross(u, a(first + 2:first + 3)), eta, rate, a(first + 4:last), &
            & effort%amplitude)
         call add_reactions(effort, system, work, body, q)
         if (allocated(effort%geometric)) call geometric_state(of%recovery, eta, effort%amplitude, effort%lacking, effort%geometric)
      end associate
   end subroutine gather_modal

   !> Internal forces at all sections of an exact beam; multipliers, Jacobians and kinematics are those of the state.
   subroutine gather_exact(effort, system, work, body, recovery, q, v, a)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      !> Its sections
      type(recovery_type), intent(in) :: recovery
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      real(wp) :: heavy(2)
      integer :: first, last, k, part
      first = system%layout%q(body)
      last = first + 3 + system%layout%n(body)
      effort%amplitude = 0.0_wp
      effort%on_frame = 0.0_wp
      call add_reactions(effort, system, work, body, q)
      heavy = a(first:first + 1) - system%model%gravity
      heavy = [dot_product(q(first + 2:first + 3), heavy), cross(q(first + 2:first + 3), heavy)]
      associate (line => work%kinematics%lines(findloc(work%kinematics%beams, body, dim=1)), u => q(first + 2:first + 3))
         call inertia_behind(line, recovery, effort%sections, heavy, cross(u, v(first + 2:first + 3)), &
            & cross(u, a(first + 2:first + 3)), a(first + 4:last), effort%exact)
         do k = 1, recovery%places
            do part = recovery%first_part(k), recovery%first_part(k + 1) - 1
               call add_behind(line, recovery, effort%sections, recovery%part_at(part), &
                  & recovery%part(part)*effort%amplitude(3*k - 2:3*k), effort%exact, effort%sections%part(:, part))
            end do
         end do
         call add_behind(line, recovery, effort%sections, system%model%bodies(body)%choice%origin, effort%on_frame, effort%exact)
         call add_sliding(effort, system, work, body, line, recovery, q)
         call turn_into_sections(effort%sections, q(first + 4:last), effort%exact)
      end associate
   end subroutine gather_exact

   !> Takes a sample into the envelope.
   pure subroutine stretch_envelope(effort, system, body, eta)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: eta(:)
      real(wp) :: value(5)
      integer :: k
      associate (recovery => system%model%bodies(body)%recovery, first => system%model%bodies(body)%point_sections)
         do k = 1, size(effort%extremes, 3)
            if (allocated(effort%exact)) then
               value(:3) = effort%exact(:, first + k)
            else
               value(:3) = internal_forces(recovery, first + k, eta, effort%amplitude, effort%geometric, &
                  & effort%lacking, effort%held)
            end if
            value(4:5) = stresses(value(:3), strength_at(system%model%bodies(body), recovery%sections(first + k)))
            effort%extremes(:, 1, k) = min(effort%extremes(:, 1, k), value)
            effort%extremes(:, 2, k) = max(effort%extremes(:, 2, k), value)
         end do
      end associate
   end subroutine stretch_envelope

   !> Joins the envelopes of an analysis to those of the ones before it.
   subroutine join_envelopes(part, whole)
      !> (bodies); unallocated if the analysis has none
      type(section_forces_type), allocatable, intent(in) :: part(:)
      type(section_forces_type), allocatable, intent(inout) :: whole(:)
      integer :: i
      if (.not. allocated(part)) return
      if (.not. allocated(whole)) then
         allocate (whole, source=part)
         return
      end if
      do i = 1, size(part)
         if (.not. allocated(part(i)%extremes)) cycle
         whole(i)%extremes(:, 1, :) = min(whole(i)%extremes(:, 1, :), part(i)%extremes(:, 1, :))
         whole(i)%extremes(:, 2, :) = max(whole(i)%extremes(:, 2, :), part(i)%extremes(:, 2, :))
      end do
   end subroutine join_envelopes

   !> Cross-section at a section of a body: as in `body_type`, the second moment of area of the curved beam, its curvature (6).
   pure function strength_at(body, section) result(strength)
      type(body_type), intent(in) :: body
      type(section_type), intent(in) :: section
      real(wp) :: strength(6), value(profile_values)
      real(wp), parameter :: beside = 1.0e-9_wp
      strength = [body%strength(:, section%member), body%strength(2, section%member), 0.0_wp]
      if (.not. allocated(body%fibres%value)) return
      value = profile_at(body%fibres, section%x + merge(beside, -beside, section%behind)*body%beam%length)
      strength = [value(:5), body%choice%exact%arc]
   end function strength_at

   !> Stresses in the extreme fibres to the left and to the right (2), of a curved beam those of Winkler and Bach, eq. (2.54).
   pure function stresses(force, strength) result(stress)
      !> Axial force, shear force, bending moment
      real(wp), intent(in) :: force(3)
      !> Cross-section, see `strength_at`
      real(wp), intent(in) :: strength(6)
      real(wp) :: stress(2), fibre(2)
      fibre = [strength(3), -strength(4)]
      stress = (force(1) + strength(6)*force(3))/strength(1) - force(3)/strength(5)*fibre/(1 - strength(6)*fibre)
   end function stresses

   !> Forces of joints, drivers and loads.
   subroutine add_reactions(effort, system, work, body, q)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      real(wp), intent(in) :: q(:)
      type(pull_type) :: pulls(most_pulls)
      real(wp) :: force(3)
      integer :: i, side, row, count
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (.not. any(item%bodies == body)) cycle
            if (effort%pulls%constraint(i)) then
               call constraint_pulls(effort%pulls, work, item, pulls, count)
               call add_pulls(effort, system, body, pulls(:count), q)
               cycle
            end if
            do side = 1, 2
               if (item%bodies(side) /= body) cycle
               if (side == 2 .and. slides(item)) cycle
               force = 0.0_wp
               do row = 1, item%rows
                  force = force - work%lambda(item%first + row - 1)*work%jacobians(side, i)%z(row, :)
               end do
               call add_force(effort, system, body, item%points(side), force, q)
            end do
         end associate
      end do
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item)
            if (.not. any(item%bodies == body)) cycle
            if (effort%pulls%load(i)) then
               call load_pulls(effort%pulls, work, item, pulls, count)
               call add_pulls(effort, system, body, pulls(:count), q)
               cycle
            end if
            effort%scratch = 0.0_wp
            call item%add_force(work%kinematics, effort%scratch(:sum(item%rates)))
            if (item%is_scaled) effort%scratch = item%share*effort%scratch
            do side = 1, size(item%bodies)
               if (item%bodies(side) == body) call add_force(effort, system, body, item%points(side), &
                  & effort%scratch(item%offsets(side) + 1:item%offsets(side) + 3), q)
            end do
         end associate
      end do
   end subroutine add_reactions

   !> Those forces among others that act on a body.
   pure subroutine add_pulls(effort, system, body, pulls, q)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      type(pull_type), intent(in) :: pulls(:)
      real(wp), intent(in) :: q(:)
      integer :: j
      do j = 1, size(pulls)
         if (pulls(j)%body == body) call add_force(effort, system, body, pulls(j)%point, pulls(j)%force, q)
      end do
   end subroutine add_pulls

   !> Whether the point of a joint slides along the second body, which its second point only names.
   pure logical function slides(item)
      class(constraint_type), intent(in) :: item
      slides = .false.
      select type (item)
      class is (beam_path_type)
         slides = .true.
      end select
   end function slides

   !> Adds the forces of points that slide along an exact beam, and of what drives them there, where they are.
   subroutine add_sliding(effort, system, work, body, line, recovery, q)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      type(centreline_type), intent(in) :: line
      type(recovery_type), intent(in) :: recovery
      real(wp), intent(in) :: q(:)
      real(wp) :: force(2), z(2), u(2), at
      integer :: i, first
      first = system%layout%q(body)
      u = q(first + 2:first + 3)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (item%bodies(2) /= body) cycle
            select type (item)
            class is (exact_path_type)
               z = point_position(system%model, system%layout, system%model%points(item%points(1)), q) - q(first:first + 1)
               z = [dot_product(u, z), cross(u, z)]
               at = foot_of(item, z, q(first + 4:first + 3 + system%layout%n(body)))
               force = -work%lambda(item%first)*work%jacobians(2, i)%z(1, 1:2)
               call add_behind(line, recovery, effort%sections, at, &
                  & [dot_product(u, force), cross(u, force), 0.0_wp], effort%exact)
            end select
         end associate
      end do
   end subroutine add_sliding

   !> A force and its moment about the frame's origin, as force and couple at a point, in the axes of the frame. What acts at no
   !> point, as a torque on the floating frame or a load along the beam, has its part in the coordinates only.
   pure subroutine add_force(effort, system, body, point, force, q)
      type(section_forces_type), intent(inout) :: effort
      type(system_type), intent(in) :: system
      !> Indices of the body and of the point; 0: none
      integer, intent(in) :: body, point
      !> Along the fixed axes (2), and moment
      real(wp), intent(in) :: force(3), q(:)
      real(wp) :: u(2), couple
      integer :: first, at
      first = system%layout%q(body)
      u = q(first + 2:first + 3)
      if (point == 0) then
         effort%on_frame = effort%on_frame + [dot_product(u, force(1:2)), cross(u, force(1:2)), force(3)]
         return
      end if
      if (effort%place(point) == 0) return
      couple = force(3) - cross(point_position(system%model, system%layout, system%model%points(point), q) &
         & - q(first:first + 1), force(1:2))
      at = size(effort%amplitude) - 3*maxval(effort%place) + 3*(effort%place(point) - 1)
      effort%amplitude(at + 1:at + 3) = effort%amplitude(at + 1:at + 3) + [dot_product(u, force(1:2)), cross(u, force(1:2)), couple]
   end subroutine add_force

   !> Axial force, shear force and bending moment at a point.
   pure function section_forces(efforts, system, point, q) result(force)
      type(section_forces_type), intent(in) :: efforts(:)
      type(system_type), intent(in) :: system
      !> Index of the point, which has a section
      integer, intent(in) :: point
      real(wp), intent(in) :: q(:)
      real(wp) :: force(3)
      integer :: body, first
      body = system%model%points(point)%body
      first = system%layout%q(body)
      if (body == ground) return
      if (allocated(efforts(body)%exact)) then
         force = efforts(body)%exact(:, system%model%points(point)%section)
         return
      end if
      force = internal_forces(system%model%bodies(body)%recovery, system%model%points(point)%section, &
         & q(first + 4:first + 3 + system%layout%n(body)), efforts(body)%amplitude, efforts(body)%geometric, &
         & efforts(body)%lacking, efforts(body)%held)
   end function section_forces

end module limber_output_internal_forces
