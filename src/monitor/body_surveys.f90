!> Surveys of the meshes of all flexible bodies. Their meshes with the loads that act on them in a state. Floor: monitor. Source:
!> doc/theory, part 7.
module limber_monitor_body_surveys
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_beam_plane_frame, only: frame_type, beam_frame, unit_load
   use limber_beam_mesh_forces, only: survey_type, new_survey
   use limber_model_model, only: body_type, point_type, ground
   use limber_model_distributed_loads, only: spread_parts
   use limber_output_point_forces, only: pull_type, pulls_type, new_pulls, pulled_points, constraint_pulls, load_pulls, most_pulls
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: surveys_type, body_survey_type, start_surveys, take_amplitudes, is_base

   !> The survey of one body
   type :: body_survey_type
      !> Index of the body
      integer :: body = 0
      type(survey_type) :: survey
      !> Amplitudes of the loads in the state that was taken last
      real(wp), allocatable :: amplitude(:)
   end type body_survey_type

   !> Those of a scene
   type :: surveys_type
      type(body_survey_type), allocatable :: bodies(:)
      !> Index into them of each body of the model, 0: none (bodies); place of each point among those of its body (points)
      integer, allocatable :: of(:), place(:)
      !> Of the forces of a load
      real(wp), allocatable :: scratch(:)
      !> What acts on several points of a body
      type(pulls_type) :: pulls
   end type surveys_type

contains

   !> Whether what holds another body at a body holds it as the ground does: the ground, and rigid bodies of known motion.
   pure logical function is_base(system, body)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      is_base = body == ground
      if (.not. is_base) is_base = system%layout%n(body) == 0 .and. system%layout%framed(body) .and. system%tree%count(body) == 0
   end function is_base

   !> Makes the surveys; bodies whose stiffness cannot be factored have none.
   subroutine start_surveys(self, system, frames_only)
      type(surveys_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Whether straight beams are left out
      logical, intent(in) :: frames_only
      logical :: wanted(size(system%model%bodies))
      integer :: i, made
      allocate (self%of(size(system%model%bodies)), self%place(size(system%model%points)))
      self%of = 0
      self%place = 0
      do i = 1, size(wanted)
         wanted(i) = system%layout%n(i) > 0 .and. (system%model%bodies(i)%is_frame .or. .not. frames_only) &
            & .and. .not. system%model%bodies(i)%reduced%is_exact
      end do
      allocate (self%bodies(count(wanted)))
      self%pulls = new_pulls(system)
      made = 0
      do i = 1, size(wanted)
         if (.not. wanted(i)) cycle
         made = made + 1
         self%of(i) = made
         self%bodies(made)%body = i
      end do
      made = 0
      do i = 1, size(system%loads)
         made = max(made, sum(system%loads(i)%item%rates))
      end do
      allocate (self%scratch(made))
      do i = 1, size(self%bodies)
         call start_body(self, system, self%bodies(i))
      end do
   end subroutine start_surveys

   !> The survey of one body.
   subroutine start_body(self, system, own)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(body_survey_type), intent(inout) :: own
      type(error_type), allocatable :: error
      type(frame_type) :: mesh
      real(wp), allocatable :: shape(:, :, :), load(:, :, :)
      integer, allocatable :: point(:)
      integer :: i
      call find_places(self, system, own%body, point)
      associate (body => system%model%bodies(own%body))
         if (body%is_frame) then
            mesh = body%mesh
            allocate (shape, source=body%shape)
         else
            call beam_frame(body%beam, body%choice%support, body%choice%origin, body%field, mesh, shape)
         end if
         allocate (load(3, size(mesh%place, 2), 3*size(point)))
         do i = 1, size(point)
            load(:, :, 3*i - 2:3*i) = place_load(system, body, mesh, point(i))
         end do
         call new_survey(mesh, shape, body%reduced%omega2, load, own%survey, error)
      end associate
      if (allocated(error)) then
         self%of(own%body) = 0
         return
      end if
      allocate (own%amplitude(size(own%survey%pull, 2)))
      own%amplitude = 0.0_wp
   end subroutine start_body

   !> Unit forces along both axes of the body, and a unit couple, at a point on the nodes; a load along the body is spread.
   function place_load(system, body, mesh, point) result(load)
      type(system_type), intent(in) :: system
      type(body_type), intent(in) :: body
      type(frame_type), intent(in) :: mesh
      !> Its index
      integer, intent(in) :: point
      real(wp) :: load(3, size(mesh%place, 2), 3)
      real(wp), allocatable :: at(:), part(:)
      integer :: i, k, spread, member
      load = 0.0_wp
      member = max(1, system%model%points(point)%member)
      spread = spread_of(system, point)
      if (spread > 0) then
         call spread_parts(system%model%spreads(spread), body, [real(wp) ::], at, part)
      else
         allocate (at(1), part(1))
         at = along_body(body, system%model%points(point))
         part = 1.0_wp
      end if
      do i = 1, size(at)
         do k = 1, 3
            load(:, :, k) = load(:, :, k) + part(i)*unit_load(mesh, member, at(i), k)
         end do
      end do
   end function place_load

   !> Index of the load along a body that a point stands for; 0: none.
   pure integer function spread_of(system, point) result(spread)
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      do spread = size(system%model%spreads), 1, -1
         if (system%model%spreads(spread)%point == point) return
      end do
   end function spread_of

   !> Coordinate of a point along its beam or member [length].
   pure real(wp) function along_body(body, point) result(x)
      type(body_type), intent(in) :: body
      type(point_type), intent(in) :: point
      x = point%along
      if (.not. body%is_frame) x = min(max(point%p0(1) + body%choice%origin, 0.0_wp), body%beam%length)
   end function along_body

   !> Where joints, drivers and loads act on a body: one of the points at each place.
   subroutine find_places(self, system, body, point)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer, allocatable, intent(out) :: point(:)
      integer :: i, side
      allocate (point(0))
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               call enter(item%bodies(side), item%points(side))
            end do
         end associate
      end do
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item)
            do side = 1, size(item%points)
               call enter(item%bodies(side), item%points(side))
            end do
         end associate
      end do
      associate (pulled => pulled_points(self%pulls, system))
         do i = 1, size(pulled)
            call enter(system%model%points(pulled(i))%body, pulled(i))
         end do
      end associate

   contains

      subroutine enter(of, at)
         integer, intent(in) :: of, at
         integer :: k
         if (of /= body .or. at == 0) return
         do k = 1, size(point)
            if (is_same(point(k), at)) exit
         end do
         if (k > size(point)) point = [point, at]
         self%place(at) = k
      end subroutine enter

      !> Whether two points are at one place of the body, and no load along it is meant.
      pure logical function is_same(a, b)
         integer, intent(in) :: a, b
         is_same = a == b
         if (is_same .or. spread_of(system, a) > 0 .or. spread_of(system, b) > 0) return
         is_same = all(abs(system%model%points(a)%p0 - system%model%points(b)%p0) <= 1.0e-9_wp*system%model%bodies(body)%size)
      end function is_same

   end subroutine find_places

   !> Takes the accelerations of a state and the loads that act in it. Kinematics are placed and moved there; Jacobians and
   !> multipliers are those of the state.
   subroutine take_amplitudes(self, system, work, q, v, a)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      integer :: i, first, n, m
      if (size(self%bodies) == 0) return
      do i = 1, size(self%bodies)
         if (self%of(self%bodies(i)%body) == 0) cycle
         first = system%layout%q(self%bodies(i)%body)
         n = system%layout%n(self%bodies(i)%body)
         associate (own => self%bodies(i), u => q(first + 2:first + 3), heavy => a(first:first + 1) - system%model%gravity, &
            & omega => cross(q(first + 2:first + 3), v(first + 2:first + 3)), &
            & alpha => cross(q(first + 2:first + 3), a(first + 2:first + 3)), chosen => self%bodies(i)%survey%chosen)
            m = size(chosen)
            own%amplitude(1:4) = [-dot_product(u, heavy), -cross(u, heavy), -alpha, omega**2]
            own%amplitude(5:4 + m) = omega**2*q(first + 3 + chosen) - a(first + 3 + chosen)
            own%amplitude(5 + m:4 + 2*m) = -alpha*q(first + 3 + chosen) - 2*omega*v(first + 3 + chosen)
            own%amplitude(5 + 2*m:) = 0.0_wp
         end associate
      end do
      call add_reactions(self, system, work, q)
      call add_loads(self, system, work, q)
   end subroutine take_amplitudes

   !> Forces of joints and drivers.
   subroutine add_reactions(self, system, work, q)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: q(:)
      type(pull_type) :: pulls(most_pulls)
      real(wp) :: force(3)
      integer :: i, side, row, count
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (self%pulls%pair(i)) then
               call constraint_pulls(self%pulls, work, item, pulls, count)
               call add_pulls(self, system, pulls(:count), q)
               cycle
            end if
            do side = 1, 2
               if (.not. is_surveyed(self, item%bodies(side), item%points(side))) cycle
               force = 0.0_wp
               do row = 1, item%rows
                  force = force - work%lambda(item%first + row - 1)*work%jacobians(side, i)%z(row, 1:3)
               end do
               call add_force(self, system, item%bodies(side), item%points(side), force, q)
            end do
         end associate
      end do
   end subroutine add_reactions

   !> Forces of loads.
   subroutine add_loads(self, system, work, q)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: q(:)
      type(pull_type) :: pulls(most_pulls)
      integer :: i, side, count
      logical :: acts
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item)
            acts = .false.
            do side = 1, size(item%points)
               acts = acts .or. is_surveyed(self, item%bodies(side), item%points(side))
            end do
            if (.not. acts) cycle
            if (self%pulls%load(i)) then
               call load_pulls(self%pulls, work, item, pulls, count)
               call add_pulls(self, system, pulls(:count), q)
               cycle
            end if
            self%scratch = 0.0_wp
            call item%add_force(work%kinematics, self%scratch(:sum(item%rates)))
            if (item%is_scaled) self%scratch = item%share*self%scratch
            do side = 1, size(item%points)
               if (is_surveyed(self, item%bodies(side), item%points(side))) call add_force(self, system, item%bodies(side), &
                  & item%points(side), self%scratch(item%offsets(side) + 1:item%offsets(side) + 3), q)
            end do
         end associate
      end do
   end subroutine add_loads

   !> Those forces among others that act on bodies that have a survey.
   pure subroutine add_pulls(self, system, pulls, q)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(pull_type), intent(in) :: pulls(:)
      real(wp), intent(in) :: q(:)
      integer :: j
      do j = 1, size(pulls)
         if (is_surveyed(self, pulls(j)%body, pulls(j)%point)) call add_force(self, system, pulls(j)%body, pulls(j)%point, &
            & pulls(j)%force, q)
      end do
   end subroutine add_pulls

   !> Whether a point lies on a body that has a survey.
   pure logical function is_surveyed(self, body, point)
      type(surveys_type), intent(in) :: self
      integer, intent(in) :: body, point
      is_surveyed = body /= ground .and. point /= 0
      if (is_surveyed) is_surveyed = self%of(body) > 0 .and. self%place(point) > 0
   end function is_surveyed

   !> A force and its moment about the origin of the body, as forces along its axes and a couple at a place.
   pure subroutine add_force(self, system, body, point, force, q)
      type(surveys_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body, point
      !> Along the fixed axes (2), and moment
      real(wp), intent(in) :: force(3), q(:)
      real(wp) :: arm(2)
      integer :: first, at
      first = system%layout%q(body)
      associate (own => self%bodies(self%of(body)), u => q(first + 2:first + 3))
         at = 4 + 2*size(own%survey%chosen) + 3*self%place(point) - 2
         arm = point_position(system%model, system%layout, system%model%points(point), q) - q(first:first + 1)
         own%amplitude(at:at + 2) = own%amplitude(at:at + 2) + [dot_product(u, force(1:2)), cross(u, force(1:2)), &
            & force(3) - cross(arm, force(1:2))]
      end associate
   end subroutine add_force

end module limber_monitor_body_surveys
