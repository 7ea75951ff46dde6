!> Monitor of the functions of exact beams by equilibrium. Bending moment and axial force that equilibrium asks for, along the beam,
!> against those that the functions make. What differs is what they leave out: displacements, vibrations under sudden loads, layers
!> under much tension, buckling that nothing begins. All are looked at here, `limber_monitor_function_report` tells of them. Floor:
!> monitor. Source: doc/theory, eqs. (7.54), (7.55).
module limber_monitor_function_watch
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_exact_beam, only: exact_type, sum_along
   use limber_beam_beam_mesh, only: support_type
   use limber_beam_force_recovery, only: recovery_type
   use limber_monitor_function_buckling, only: buckling_type, start_buckling, observe_buckling, join_buckling
   use limber_monitor_function_layers, only: layers_type, start_layers, observe_layers, join_layers
   use limber_monitor_function_sudden, only: sudden_type, start_sudden, observe_sudden, join_sudden, is_struck, &
      & share_that_stays, at_rest
   use limber_monitor_met_ends, only: met_ends_type, start_met_ends, observe_met_ends, join_met_ends
   use limber_model_force_sections, only: recover_stations
   use limber_output_exact_forces, only: find_lack, settle_stations
   use limber_output_internal_forces, only: section_forces_type, start_effort, gather_exact
   use limber_model_quantities, only: quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, &
      & quantity_torque, quantity_force, quantity_power
   use limber_model_model, only: place_on_beam, place_at_point, model_type, body_point, body_flexible, driver_joint_angle, &
      & driver_x, driver_y, ground
   use limber_output_joint_forces, only: joint_force, driver_effort, joint_force_in_frame, frame_of
   use limber_multibody_plane_vectors, only: turn, along, cross
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: function_watch_type, beam_watch_type, start_functions, observe_functions, join_functions
   public :: lacking_strains, reaction_type, starts_struck, station_of

   !> What is left out of one beam
   type :: beam_watch_type
      !> Index of the body
      integer :: body = 0
      !> Its stations as sections, and what acts there
      type(recovery_type) :: recovery
      type(section_forces_type) :: effort
      !> Largest displacements of the axis in the frame, along it, and by the angle alone [length]; largest ones that are left
      !> out, of bending and shear and of stretch, and when
      real(wp) :: moved = 0.0_wp, moved_along = 0.0_wp, moved_by_angle = 0.0_wp, left_out(2) = 0.0_wp, when(2) = 0.0_wp
      !> At rest, where a scene with more functions was there to tell: the largest error of a bending moment, and the largest moment
      real(wp) :: moment_off = 0.0_wp, moment = 0.0_wp
      !> Vibrations that it does not follow, and layers
      type(sudden_type) :: sudden
      type(layers_type) :: layers
      !> Compression while it stays straight
      type(buckling_type) :: buckling
      !> Stations of its joints, and largest components of the axes of its sections there, along those of each reaction: of the axes
      !> across the beam and of those along it (4, reactions)
      integer, allocatable :: held_at(:)
      real(wp), allocatable :: across(:, :), along(:, :)
      !> The same along the direction of each driver that has one, else 1: of the axes across the beam and along it (2, driven)
      real(wp), allocatable :: drawn_by(:, :)
   end type beam_watch_type

   !> The force of a joint that channels ask for
   type :: reaction_type
      integer :: joint = 0
      !> Largest components along the fixed axes, and along those of the second body's frame
      real(wp) :: largest(4) = 0.0_wp
   end type reaction_type

   !> The torque or force of a driver that channels ask for
   type :: driven_type
      integer :: driver = 0
      !> Lever by which forces act on it at most [length], of a force 1; largest torque or force
      real(wp) :: lever = 1.0_wp, largest = 0.0_wp
      !> 1, 2: the point that it draws along x or y takes all forces of the beams that it is joined to; 0: they reach it by levers.
      !> Whether it slides along the beams, and takes no forces along them
      integer :: axis = 0
      logical :: slides = .false.
   end type driven_type

   !> All exact beams
   type :: function_watch_type
      type(beam_watch_type), allocatable :: beams(:)
      !> What the next state is, see `limber_monitor_function_sudden`
      integer :: kind = at_rest
      !> Forces in motion that channels ask for
      type(reaction_type), allocatable :: reactions(:)
      type(driven_type), allocatable :: driven(:)
      !> Ends that meet
      type(met_ends_type) :: ends
   contains
      procedure :: exchange
   end type function_watch_type

contains

   !> Begins to watch.
   subroutine start_functions(self, system)
      type(function_watch_type), intent(out) :: self
      type(system_type), intent(in) :: system
      integer :: i, k
      allocate (self%beams(count(system%model%bodies%reduced%is_exact)))
      k = 0
      do i = 1, size(system%model%bodies)
         if (.not. system%model%bodies(i)%reduced%is_exact) cycle
         k = k + 1
         self%beams(k)%body = i
         call recover_stations(system%model, i, self%beams(k)%recovery)
         call start_effort(self%beams(k)%effort, system, i, self%beams(k)%recovery)
         call start_sudden(self%beams(k)%sudden, system%model%bodies(i)%reduced, &
            & system%model%bodies(i)%choice%exact%support)
         call start_layers(self%beams(k)%layers, system%model%bodies(i))
         call start_buckling(self%beams(k)%buckling, system%model, i)
      end do
      call start_reactions(self, system%model)
      call start_met_ends(self%ends, system%model)
      call start_driven(self, system%model)
   end subroutine start_functions

   !> The drivers that channels ask for.
   subroutine start_driven(self, model)
      type(function_watch_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      logical :: asked(size(model%drivers))
      integer :: i, k
      asked = .false.
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(k))
               if (quantity%of_load .or. quantity%of_coupler .or. quantity%of > size(asked)) cycle
               if (any(quantity%kind == [quantity_torque, quantity_force, quantity_power])) asked(quantity%of) = .true.
            end associate
         end do
      end do
      if (size(self%beams) == 0) asked = .false.
      allocate (self%driven(count(asked)))
      self%driven%driver = pack([(i, i=1, size(asked))], asked)
      do i = 1, size(self%driven)
         associate (driver => model%drivers(self%driven(i)%driver))
            if (driver%body > 0) self%driven(i)%lever = largest_lever(model, driver%body)
            if (driver%joint > 0 .and. driver%kind == driver_joint_angle) self%driven(i)%lever = maxval([(largest_lever(model, &
               & body_of(model, model%joints(driver%joint)%points(k))), k=1, 2)])
            if (any(driver%kind == [driver_x, driver_y])) call find_axis(model, driver%points(1), self%driven(i))
            if (self%driven(i)%axis > 0 .and. driver%kind == driver_y) self%driven(i)%axis = 2
         end associate
      end do
      do k = 1, size(self%beams)
         allocate (self%beams(k)%drawn_by(2, size(self%driven)), source=1.0_wp)
         do i = 1, size(self%driven)
            if (self%driven(i)%axis > 0) self%beams(k)%drawn_by(:, i) = 0.0_wp
         end do
      end do
   end subroutine start_driven

   !> Whether a point that is drawn is all that forces of beams act on: a point mass, or the one point by which its body is joined.
   pure subroutine find_axis(model, point, driven)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      type(driven_type), intent(inout) :: driven
      integer :: body, i, side, other
      if (point == 0) return
      body = model%points(point)%body
      if (body == ground) return
      if (model%bodies(body)%kind == body_flexible) return
      driven%slides = .true.
      do i = 1, size(model%joints)
         do side = 1, 2
            if (body_of(model, model%joints(i)%points(side)) /= body) cycle
            other = body_of(model, model%joints(i)%points(3 - side))
            if (other == ground) return
            if (.not. model%bodies(other)%reduced%is_exact) return
            if (model%bodies(body)%kind /= body_point .and. norm2(model%points(point)%p0 &
               & - model%points(model%joints(i)%points(side))%p0) > 0.0_wp) return
            driven%slides = driven%slides .and. model%joints(i)%place == place_on_beam
         end do
      end do
      driven%axis = 1
   end subroutine find_axis

   pure integer function body_of(model, point) result(body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      body = 0
      if (point > 0) body = model%points(point)%body
   end function body_of

   !> Largest distance of two joints of a body [length].
   pure real(wp) function largest_lever(model, body) result(lever)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      real(wp) :: place(2, 2*size(model%joints))
      integer :: i, k, n, side
      lever = 0.0_wp
      if (body == ground) return
      n = 0
      do i = 1, size(model%joints)
         do side = 1, 2
            if (model%joints(i)%points(side) == 0) cycle
            associate (point => model%points(model%joints(i)%points(side)))
               if (point%body /= body) cycle
               n = n + 1
               place(:, n) = point%p0
            end associate
         end do
      end do
      do i = 1, n
         do k = 1, i - 1
            lever = max(lever, norm2(place(:, i) - place(:, k)))
         end do
      end do
   end function largest_lever

   !> The joints whose forces channels ask for, and where joints hold the beams.
   subroutine start_reactions(self, model)
      type(function_watch_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      logical :: asked(size(model%joints))
      integer :: at(2*size(model%joints)), i, k
      asked = .false.
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(k))
               if (quantity%of_load .or. quantity%of_coupler .or. quantity%of > size(asked)) cycle
               if (any(quantity%kind == [quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2])) &
                  & asked(quantity%of) = .true.
            end associate
         end do
      end do
      if (size(self%beams) == 0) asked = .false.
      allocate (self%reactions(count(asked)))
      self%reactions%joint = pack([(i, i=1, size(asked))], asked)
      do k = 1, size(self%beams)
         do i = 1, size(model%joints)
            at(2*i - 1) = station_of(model, self%beams(k)%body, model%joints(i)%points(1))
            at(2*i) = station_of(model, self%beams(k)%body, model%joints(i)%points(2))
         end do
         self%beams(k)%held_at = pack(at, at > 0)
         allocate (self%beams(k)%across(4, size(self%reactions)), self%beams(k)%along(4, size(self%reactions)), source=0.0_wp)
      end do
   end subroutine start_reactions

   !> The station of an exact beam that is nearest to a point; 0 if that is not of the beam.
   pure integer function station_of(model, body, point) result(at)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body, point
      at = 0
      if (point == 0) return
      if (model%points(point)%body /= body) return
      associate (own => model%bodies(body))
         at = minloc(abs(own%reduced%exact%s - own%choice%exact%origin - model%points(point)%p0(1)), dim=1)
      end associate
   end function station_of

   !> Whether the start without deflections sets off vibrations of a beam.
   pure logical function starts_struck(self)
      type(function_watch_type), intent(in) :: self
      integer :: k
      starts_struck = .false.
      do k = 1, size(self%beams)
         starts_struck = starts_struck .or. is_struck(self%beams(k)%sudden)
      end do
   end function starts_struck

   !> Takes in a state. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe_functions(self, system, work, t, q, v, a)
      type(function_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      integer :: i, first, last
      do i = 1, size(self%beams)
         associate (beam => self%beams(i))
            call gather_exact(beam%effort, system, work, beam%body, beam%recovery, q, v, a)
            first = system%layout%q(beam%body) + 4
            last = first - 1 + system%layout%n(beam%body)
            call compare(beam, system, self%kind, t, q(first:last), v(first:last), a(first:last))
         end associate
      end do
      call observe_met_ends(self%ends, system, t, q)
      if (self%kind == at_rest) return
      do i = 1, size(self%reactions)
         call observe_reaction(self, system, work, q, i)
      end do
      do i = 1, size(self%driven)
         self%driven(i)%largest = max(self%driven(i)%largest, abs(driver_effort(system, work, self%driven(i)%driver)))
         if (self%driven(i)%axis > 0) call observe_drawn(self, system, q, i)
      end do
   end subroutine observe_functions

   !> How beams lie to the direction in which a driver draws what they are joined to.
   subroutine observe_drawn(self, system, q, which)
      type(function_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      integer, intent(in) :: which
      real(wp) :: angle, normal(2), tangent(2)
      integer :: i, k, first
      associate (driven => self%driven(which))
         do i = 1, size(self%beams)
            first = system%layout%q(self%beams(i)%body)
            associate (exact => system%model%bodies(self%beams(i)%body)%reduced%exact, most => self%beams(i)%drawn_by(:, which))
               do k = 1, exact%stations
                  angle = exact%lean(k) + dot_product(exact%psi(:, k), q(first + 4:first + 3 + exact%angles))
                  normal = along(q(first + 2:first + 3), [-sin(angle), cos(angle)])
                  tangent = turn(normal)
                  most(1) = max(most(1), abs(normal(driven%axis)))
                  if (.not. driven%slides) most(2) = max(most(2), abs(tangent(driven%axis)))
               end do
            end associate
         end do
      end associate
   end subroutine observe_drawn

   !> The force of a joint, and how beams that may pass errors on to it lie to its axes.
   subroutine observe_reaction(self, system, work, q, which)
      type(function_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: q(:)
      integer, intent(in) :: which
      real(wp) :: axes(2), normal(2), angle, force(2)
      integer :: i, k, first
      logical :: guided
      associate (own => self%reactions(which))
         force = joint_force(system, work, own%joint)
         own%largest = max(own%largest, abs([force, joint_force_in_frame(system, work, own%joint, q)]))
         axes = frame_of(system, system%constraints(own%joint)%item%bodies(2), q)
         ! All but hinges and welds take forces of one direction only
         guided = system%model%joints(own%joint)%place /= place_at_point
      end associate
      if (guided) force = force/max(norm2(force), tiny(force))
      do i = 1, size(self%beams)
         first = system%layout%q(self%beams(i)%body)
         associate (exact => system%model%bodies(self%beams(i)%body)%reduced%exact, beam => self%beams(i))
            do k = 1, size(beam%held_at)
               associate (at => beam%held_at(k))
                  angle = exact%lean(at) + dot_product(exact%psi(:, at), q(first + 4:first + 3 + exact%angles))
               end associate
               normal = along(q(first + 2:first + 3), [-sin(angle), cos(angle)])
               beam%across(:, which) = max(beam%across(:, which), components(normal))
               beam%along(:, which) = max(beam%along(:, which), components(turn(normal)))
            end do
         end associate
      end do

   contains

      !> Components of a direction along the fixed axes and those of the second body, as far as the joint takes forces there.
      pure function components(direction)
         real(wp), intent(in) :: direction(2)
         real(wp) :: components(4), taken(2)
         taken = direction
         if (guided) taken = force*dot_product(force, direction)
         components = abs([taken, dot_product(axes, taken), cross(axes, taken)])
      end function components

   end subroutine observe_reaction

   !> Strains that equilibrium asks for less those that the functions make: curvature, stretch, shear (3, stations), eq. (7.54).
   !> Kinematics, Jacobians, multipliers as for `observe_functions`.
   subroutine lacking_strains(self, system, work, beam, q, v, a, lack)
      type(function_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Which of the beams of the watch
      integer, intent(in) :: beam
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      real(wp), allocatable, intent(inout) :: lack(:, :)
      integer :: first, last
      associate (own => self%beams(beam))
         call gather_exact(own%effort, system, work, own%body, own%recovery, q, v, a)
         first = system%layout%q(own%body) + 4
         last = first - 1 + system%layout%n(own%body)
         if (allocated(lack)) deallocate (lack)
         allocate (lack(3, size(own%recovery%sections)))
         call find_lack(system%model%bodies(own%body), own%effort%exact, q(first:last), v(first:last), lack)
      end associate
   end subroutine lacking_strains

   !> What equilibrium asks for less what the functions make, as displacements of the axis, eqs. (7.54), (7.55).
   subroutine compare(beam, system, state, t, eta, rate, acceleration)
      type(beam_watch_type), intent(inout) :: beam
      type(system_type), intent(in) :: system
      !> What the state is
      integer, intent(in) :: state
      !> Time; coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: t, eta(:), rate(:), acceleration(:)
      real(wp) :: own, lack(3, size(beam%recovery%sections)), forces(3, size(beam%recovery%sections))
      real(wp), dimension(size(beam%recovery%sections)) :: bend, turned
      real(wp), dimension(size(beam%recovery%sections), 2) :: g, bent, stretch, slide, place
      integer :: k, a
      associate (body => system%model%bodies(beam%body), exact => system%model%bodies(beam%body)%reduced%exact)
         a = exact%angles
         call find_lack(body, beam%effort%exact, eta, rate, lack)
         bend = lack(1, :)
         forces = beam%effort%exact
         call settle_stations(body, eta, lack(1, :), forces)
         call observe_sudden(beam%sudden, exact, state, t, eta - exact%rest, rate, acceleration, &
            & lack(:2, :), forces)
         call observe_layers(beam%layers, exact, t, eta, beam%effort%exact)
         do k = 1, exact%stations
            own = exact%lean(k) + dot_product(exact%psi(:, k), eta(:a))
            associate (axis => [cos(own), sin(own)])
               g(k, :) = along([1.0_wp + dot_product(exact%chi(1, :, k), eta(a + 1:)), &
                  & dot_product(exact%chi(2, :, k), eta(a + 1:))], axis)
               bent(k, :) = axis - [cos(exact%lean(k)), sin(exact%lean(k))]
               stretch(k, :) = axis*lack(2, k)
               slide(k, :) = turn(axis)*lack(3, k)
            end associate
         end do
         turned = sum_along(exact, bend) - sum(exact%base*bend)
         slide(:, 1) = slide(:, 1) - turned*g(:, 2)
         slide(:, 2) = slide(:, 2) + turned*g(:, 1)
         g(:, 1) = g(:, 1) - cos(exact%lean)
         g(:, 2) = g(:, 2) - sin(exact%lean)
         call displace(exact, body%choice%exact%support, g, place)
         beam%moved = max(beam%moved, farthest(place))
         beam%moved_along = max(beam%moved_along, maxval(abs(place(:, 1))))
         if (state /= at_rest) call observe_buckling(beam%buckling, t, &
            & -sum(exact%weight*beam%effort%exact(1, :))/exact%total, maxval(abs(place(:, 2))), exact%total)
         call displace(exact, body%choice%exact%support, slide, place)
         ! Right behind a jump of loads damped beams have not moved yet, and what is lacking there may be gone soon
         call note(1, farthest(place)*share_that_stays(beam%sudden, state, t))
         call displace(exact, body%choice%exact%support, bent, place)
         beam%moved_by_angle = max(beam%moved_by_angle, farthest(place))
         ! Beams stretch between their ends, too
         call displace(exact, support_type(), stretch, place)
         call note(2, farthest(place))
      end associate

   contains

      !> Keeps the largest.
      subroutine note(kind, size_of)
         integer, intent(in) :: kind
         real(wp), intent(in) :: size_of
         if (size_of <= beam%left_out(kind)) return
         beam%left_out(kind) = size_of
         beam%when(kind) = t
      end subroutine note

   end subroutine compare

   !> Largest of some displacements (stations, 2).
   pure real(wp) function farthest(place)
      real(wp), intent(in) :: place(:, :)
      integer :: k
      farthest = 0.0_wp
      do k = 1, size(place, 1)
         farthest = max(farthest, norm2(place(k, :)))
      end do
   end function farthest

   !> Displacements that changes of g make; from the chord where the end is held as well.
   pure subroutine displace(exact, support, g, place)
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      !> (stations, 2)
      real(wp), intent(in) :: g(:, :)
      real(wp), intent(out) :: place(:, :)
      integer :: i
      do i = 1, 2
         place(:, i) = sum_along(exact, g(:, i)) - sum(exact%base*g(:, i))
         if (support%w_end) place(:, i) = place(:, i) + sum(exact%base*g(:, i)) - exact%s/exact%total*sum(exact%weight*g(:, i))
      end do
   end subroutine displace

   !> Joins what an analysis has seen to that of those before.
   subroutine join_functions(part, whole)
      type(function_watch_type), intent(in) :: part
      type(function_watch_type), intent(inout) :: whole
      integer :: i, kind
      do i = 1, size(whole%beams)
         associate (beam => whole%beams(i), own => part%beams(i))
            beam%moved = max(beam%moved, own%moved)
            beam%moved_along = max(beam%moved_along, own%moved_along)
            beam%moved_by_angle = max(beam%moved_by_angle, own%moved_by_angle)
            do kind = 1, 2
               if (own%left_out(kind) <= beam%left_out(kind)) cycle
               beam%left_out(kind) = own%left_out(kind)
               beam%when(kind) = own%when(kind)
            end do
            beam%moment_off = max(beam%moment_off, own%moment_off)
            beam%moment = max(beam%moment, own%moment)
            call join_sudden(own%sudden, beam%sudden)
            call join_layers(own%layers, beam%layers)
            call join_buckling(own%buckling, beam%buckling)
            beam%across = max(beam%across, own%across)
            beam%along = max(beam%along, own%along)
            beam%drawn_by = max(beam%drawn_by, own%drawn_by)
         end associate
      end do
      do i = 1, size(whole%reactions)
         whole%reactions(i)%largest = max(whole%reactions(i)%largest, part%reactions(i)%largest)
      end do
      call join_met_ends(part%ends, whole%ends)
      whole%driven%largest = max(whole%driven%largest, part%driven%largest)
   end subroutine join_functions

   !> Saves or restores it.
   subroutine exchange(self, snapshot)
      class(function_watch_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      do i = 1, size(self%beams)
         call snapshot%exchange('moved', self%beams(i)%moved)
         call snapshot%exchange('moved_along', self%beams(i)%moved_along)
         call snapshot%exchange('moved_by_angle', self%beams(i)%moved_by_angle)
         call snapshot%exchange('moment_off', self%beams(i)%moment_off)
         call snapshot%exchange('moment', self%beams(i)%moment)
         call snapshot%exchange('left_out_1', self%beams(i)%left_out(1))
         call snapshot%exchange('left_out_2', self%beams(i)%left_out(2))
         call snapshot%exchange('when_1', self%beams(i)%when(1))
         call snapshot%exchange('when_2', self%beams(i)%when(2))
         call self%beams(i)%sudden%exchange(snapshot)
         call self%beams(i)%layers%exchange(snapshot)
         call self%beams(i)%buckling%exchange(snapshot)
         call snapshot%keep('across', self%beams(i)%across)
         call snapshot%keep('along', self%beams(i)%along)
         call snapshot%keep('drawn_by', self%beams(i)%drawn_by)
      end do
      call self%ends%exchange(snapshot)
      if (.not. allocated(self%reactions)) return
      do i = 1, size(self%reactions)
         call snapshot%exchange('reaction', self%reactions(i)%largest)
      end do
      do i = 1, size(self%driven)
         call snapshot%exchange('driven', self%driven(i)%largest)
      end do
      ! Not saved: kind
   end subroutine exchange

end module limber_monitor_function_watch
