!> Monitor of membrane forces of frames. The finite elements of the frame at rest, under the shortening of each element, as joints
!> with the ground and with rigid bodies hold them. The floating frame of reference leaves these forces out. Made at the first look.
!> Floor: monitor. Source: doc/theory, eqs. (7.41)-(7.43).
!>
!>     call start_membrane(self, system, work, surveys, own, q)   ! allocates; the state gives the directions of the joints
!>     call find_membrane(self, survey, eta)                      ! self%force of each element, self%push on the coordinates
module limber_monitor_membrane
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_monitor_body_surveys, only: surveys_type, body_survey_type, is_base
   use limber_beam_plane_frame, only: frame_type, own_displacements
   use limber_beam_frame_solver, only: solve_static
   use limber_beam_mesh_forces, only: survey_type
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: membrane_type, start_membrane, find_membrane, moved_by, pull_nodes, tension_times

   !> The constants of one frame, and what was found last
   type :: membrane_type
      !> Whether the constants are made, and whether anything can hold the ends of members apart
      logical :: made = .false., redundant = .false.
      !> Force of each joint on the nodes, and the displacements that it makes (3, nodes, rows)
      real(wp), allocatable :: load(:, :, :), response(:, :, :)
      !> Of the equations of these forces and of the motions of the body and of those that it is joined to: the inverse (n, n),
      !> n = rows + motions
      real(wp), allocatable :: inverse(:, :)
      !> Axial force of each element that the shortening makes (elements) [force]
      real(wp), allocatable :: force(:)
      !> Work of these forces on the slopes that the rotation of the body (0) and the chosen coordinates make (0:chosen)
      real(wp), allocatable :: push(:)
      !> Scratch: displacements of the coordinates, others, forces (3, nodes), right-hand side and forces of joints (n),
      !> shortening (elements)
      real(wp), allocatable :: bent(:, :), u(:, :), nodal(:, :), side(:), lambda(:), strain(:)
   end type membrane_type

   !> Part of the largest eigenvalue below which equations depend on each other
   real(wp), parameter :: dependent = 1.0e-8_wp

contains

   !> Makes the constants of a frame. Kinematics and Jacobians are those of the state.
   subroutine start_membrane(self, system, work, surveys, own, q)
      type(membrane_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(surveys_type), intent(in) :: surveys
      type(body_survey_type), intent(in) :: own
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: first(size(system%model%bodies))
      real(wp), allocatable :: rigid(:, :)
      integer :: rows, motions, loops, i
      self%made = .true.
      associate (survey => own%survey, mesh => own%survey%mesh)
         allocate (self%load(3, size(mesh%place, 2), system%nc))
         call find_partners(system, own%body, first, motions)
         allocate (rigid(motions, system%nc))
         call find_joints(self, system, work, surveys, own, q, first, rows, rigid)
         loops = size(mesh%member) - size(mesh%place, 2) + 1
         self%redundant = loops > 0 .or. rows > motions .or. count(.not. mesh%free) > 3
         allocate (self%response(3, size(mesh%place, 2), rows))
         do i = 1, rows
            self%load(:, :, i) = merge(self%load(:, :, i), 0.0_wp, mesh%free)
            call solve_static(mesh, survey%solver, self%load(:, :, i), self%response(:, :, i))
         end do
         call invert(self, rows, rigid(:, :rows), maxval(maxval(mesh%place, dim=2) - minval(mesh%place, dim=2)))
         if (.not. self%redundant) return
         allocate (self%force(size(mesh%member)), self%strain(size(mesh%member)), self%push(0:size(survey%chosen)))
         allocate (self%bent(3, size(mesh%place, 2)), self%u(3, size(mesh%place, 2)), self%nodal(3, size(mesh%place, 2)))
         allocate (self%side(rows + motions), self%lambda(rows + motions))
      end associate
   end subroutine start_membrane

   !> Rigid bodies that joints connect with the frame, one by the other: where their motions stand behind those of the frame.
   pure subroutine find_partners(system, body, first, motions)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      !> The place before the first motion of each body (bodies); -1: none
      integer, intent(out) :: first(:)
      !> Of the frame and all these
      integer, intent(out) :: motions
      !> Most motions
      integer, parameter :: most = 60
      logical :: changed
      integer :: i, side, other
      first = -1
      first(body) = 0
      motions = 3
      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, size(system%constraints)
            associate (ends => system%constraints(i)%item%bodies)
               do side = 1, 2
                  other = ends(3 - side)
                  if (is_base(system, ends(side)) .or. is_base(system, other)) cycle
                  if (first(ends(side)) < 0 .or. first(other) >= 0) cycle
                  if (system%layout%n(other) > 0 .or. motions + system%layout%rates(other) > most) cycle
                  first(other) = motions
                  motions = motions + system%layout%rates(other)
                  changed = .true.
               end do
            end associate
         end do
      end do
   end subroutine find_partners

   !> The forces of joints of the frame and of these bodies with each other, with the ground, and with rigid bodies of known motion,
   !> for unit multipliers: on the nodes, and on the motions.
   subroutine find_joints(self, system, work, surveys, own, q, motion, rows, rigid)
      type(membrane_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(surveys_type), intent(in) :: surveys
      type(body_survey_type), intent(in) :: own
      real(wp), intent(in) :: q(:)
      !> The place before the first motion of each body (bodies)
      integer, intent(in) :: motion(:)
      !> How many
      integer, intent(out) :: rows
      !> On the frame along both its axes, and about its origin; on the rates of the others (motions, rows)
      real(wp), intent(out) :: rigid(:, :)
      real(wp) :: force(3), arm(2)
      integer :: i, side, row, first, place, m
      first = system%layout%q(own%body)
      rows = 0
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item, u => q(first + 2:first + 3))
            if (.not. (takes_part(item%bodies(1)) .or. takes_part(item%bodies(2)))) cycle
            if (.not. all([(takes_part(item%bodies(side)) .or. is_base(system, item%bodies(side)), side=1, 2)])) cycle
            do row = 1, item%rows
               rows = rows + 1
               rigid(:, rows) = 0.0_wp
               self%load(:, :, rows) = 0.0_wp
               do side = 1, 2
                  if (.not. takes_part(item%bodies(side))) cycle
                  if (item%bodies(side) /= own%body) then
                     m = system%layout%rates(item%bodies(side))
                     associate (to => motion(item%bodies(side)))
                        rigid(to + 1:to + m, rows) = work%jacobians(side, i)%z(row, :m)
                     end associate
                     cycle
                  end if
                  force = work%jacobians(side, i)%z(row, 1:3)
                  rigid(:3, rows) = [dot_product(u, force(1:2)), cross(u, force(1:2)), force(3)]
                  if (item%points(side) == 0) cycle
                  place = surveys%place(item%points(side))
                  if (place == 0) cycle
                  arm = point_position(system%model, system%layout, system%model%points(item%points(side)), q) - q(first:first + 1)
                  self%load(:, :, rows) = rigid(1, rows)*own%survey%load(:, :, 3*place - 2) &
                     & + rigid(2, rows)*own%survey%load(:, :, 3*place - 1) &
                     & + (force(3) - cross(arm, force(1:2)))*own%survey%load(:, :, 3*place)
               end do
            end do
         end associate
      end do

   contains

      pure logical function takes_part(body)
         integer, intent(in) :: body
         takes_part = .false.
         if (.not. is_base(system, body)) takes_part = motion(body) >= 0
      end function takes_part

   end subroutine find_joints

   !> Inverse of the equations of the joints' forces and of the motion of the body, eq. (7.42); equations that depend on others
   !> take no part.
   subroutine invert(self, rows, rigid, extent)
      type(membrane_type), intent(inout) :: self
      integer, intent(in) :: rows
      !> (motions, rows), size of the frame [length]
      real(wp), intent(in) :: rigid(:, :), extent
      !> Arm of a joint about the origin that is none, in parts of the size: its place is that of a bent frame
      real(wp), parameter :: no_arm = 1.0e-3_wp
      real(wp), dimension(rows + size(rigid, 1)) :: scale, value
      real(wp) :: matrix(size(scale), size(scale)), room(8*size(scale)), size_of
      integer :: i, j, n, info
      n = size(scale)
      matrix = 0.0_wp
      scale = 1.0_wp
      do j = 1, rows
         do i = 1, rows
            matrix(i, j) = sum(self%load(:, :, i)*self%response(:, :, j))
         end do
         matrix(j, rows + 1:) = rigid(:, j)
         matrix(rows + 1:, j) = rigid(:, j)
      end do
      do j = 1, rows
         if (matrix(j, j) > 0.0_wp) scale(j) = 1/sqrt(matrix(j, j))
      end do
      do j = rows + 1, n
         size_of = norm2(scale(:rows)*matrix(:rows, j))
         if (size_of > 0.0_wp) scale(j) = 1/size_of
         ! Joints at the origin leave the rotation free
         if (j == rows + 3 .and. .not. size_of > no_arm*extent*max(norm2(scale(:rows)*matrix(:rows, rows + 1)), &
            & norm2(scale(:rows)*matrix(:rows, rows + 2)))) scale(j) = 0.0_wp
      end do
      do j = 1, n
         matrix(:, j) = scale*matrix(:, j)*scale(j)
      end do
      call dsyev('V', 'L', n, matrix, n, value, room, size(room), info)
      allocate (self%inverse(n, n))
      self%inverse = 0.0_wp
      if (info /= 0) return
      do i = 1, n
         if (.not. abs(value(i)) > dependent*maxval(abs(value))) cycle
         do j = 1, n
            self%inverse(:, j) = self%inverse(:, j) + scale*matrix(:, i)*(matrix(j, i)*scale(j)/value(i))
         end do
      end do
   end subroutine invert

   !> The axial forces that the shortening of a state makes, eqs. (7.41), (7.42), and their work on slopes.
   subroutine find_membrane(self, survey, eta)
      type(membrane_type), intent(inout) :: self
      type(survey_type), intent(in) :: survey
      !> Coordinates (n)
      real(wp), intent(in) :: eta(:)
      real(wp) :: own(6)
      integer :: e, i, rows
      rows = size(self%response, 3)
      associate (mesh => survey%mesh)
         self%bent = 0.0_wp
         do i = 1, size(eta)
            self%bent = self%bent + survey%shape(:, :, i)*eta(i)
         end do
         self%nodal = 0.0_wp
         do e = 1, size(mesh%member)
            own = own_displacements(mesh, e, self%bent)
            self%strain(e) = 0.5_wp*dot_product(own([2, 3, 5, 6]), tension_times(own([2, 3, 5, 6]), mesh%length(e)))/mesh%length(e)
            call pull_nodes(mesh, e, mesh%ea(e)*self%strain(e), self%nodal)
         end do
         self%nodal = merge(self%nodal, 0.0_wp, mesh%free)
         call solve_static(mesh, survey%solver, self%nodal, self%u)
         self%side = 0.0_wp
         do i = 1, rows
            self%side(i) = -sum(self%load(:, :, i)*self%u)
         end do
         self%lambda = matmul(self%inverse, self%side)
         do i = 1, rows
            self%u = self%u + self%lambda(i)*self%response(:, :, i)
         end do
         do e = 1, size(mesh%member)
            own = own_displacements(mesh, e, self%u)
            self%force(e) = mesh%ea(e)*((own(4) - own(1))/mesh%length(e) + self%strain(e))
         end do
      end associate
      call push_coordinates(self, survey)
   end subroutine find_membrane

   !> What the joints make of displacements of the nodes that the frame by itself would have: a motion of the frame, and where that
   !> is not enough forces of the joints, eq. (7.42).
   subroutine moved_by(self, mesh, u, motion)
      type(membrane_type), intent(in) :: self
      type(frame_type), intent(in) :: mesh
      !> (3, nodes)
      real(wp), intent(inout) :: u(:, :)
      !> That motion, contained in u: along both axes of the frame, and rotation
      real(wp), intent(out) :: motion(3)
      real(wp) :: side(size(self%inverse, 1))
      integer :: i, rows
      rows = size(self%response, 3)
      side = 0.0_wp
      do i = 1, rows
         side(i) = -sum(self%load(:, :, i)*u)
      end do
      side = matmul(self%inverse, side)
      do i = 1, rows
         u = u + side(i)*self%response(:, :, i)
      end do
      motion = side(rows + 1:rows + 3)
      u(1, :) = u(1, :) + motion(1) - motion(3)*mesh%place(2, :)
      u(2, :) = u(2, :) + motion(2) + motion(3)*mesh%place(1, :)
      u(3, :) = u(3, :) + motion(3)
   end subroutine moved_by

   !> Work of the axial forces that were found, on the slopes of the state with those of rotation and coordinates.
   subroutine push_coordinates(self, survey)
      type(membrane_type), intent(inout) :: self
      type(survey_type), intent(in) :: survey
      real(wp) :: own(6), force(4)
      integer :: e, i, k
      associate (mesh => survey%mesh)
         self%nodal = 0.0_wp
         self%push(0) = 0.0_wp
         do e = 1, size(mesh%member)
            own = own_displacements(mesh, e, self%bent)
            force = self%force(e)*tension_times(own([2, 3, 5, 6]), mesh%length(e))
            self%push(0) = self%push(0) + self%force(e)*(own(5) - own(2))
            do k = 1, 2
               associate (node => mesh%ends(k, e), axis => mesh%axis(:, e))
                  self%nodal(:, node) = self%nodal(:, node) + [-axis(2)*force(2*k - 1), axis(1)*force(2*k - 1), force(2*k)]
               end associate
            end do
         end do
         do i = 1, size(survey%chosen)
            self%push(i) = sum(survey%shape(:, :, survey%chosen(i))*self%nodal)
         end do
      end associate
   end subroutine push_coordinates

   !> Forces of an element under tension on its nodes.
   pure subroutine pull_nodes(mesh, e, tension, nodal)
      type(frame_type), intent(in) :: mesh
      integer, intent(in) :: e
      real(wp), intent(in) :: tension
      real(wp), intent(inout) :: nodal(:, :)
      nodal(1:2, mesh%ends(1, e)) = nodal(1:2, mesh%ends(1, e)) + tension*mesh%axis(:, e)
      nodal(1:2, mesh%ends(2, e)) = nodal(1:2, mesh%ends(2, e)) - tension*mesh%axis(:, e)
   end subroutine pull_nodes

   !> Geometric stiffness of an element of length l under unit tension, eq. (2.2), times (w, theta) of both ends.
   pure function tension_times(own, l) result(force)
      real(wp), intent(in) :: own(4), l
      real(wp) :: force(4), tilt
      tilt = (own(3) - own(1))/l
      force(3) = 1.2_wp*tilt - 0.1_wp*(own(2) + own(4))
      force(1) = -force(3)
      force(2) = l*((4*own(2) - own(4))/30 - 0.1_wp*tilt)
      force(4) = l*((4*own(4) - own(2))/30 - 0.1_wp*tilt)
   end function tension_times

end module limber_monitor_membrane
