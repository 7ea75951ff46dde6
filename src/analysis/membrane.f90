!> Axial forces of frames whose members cannot shorten as they bend, because supports or other members hold their ends apart:
!> the finite elements of the frame at rest, under the shortening of each element, as the joints with the ground hold them.
!> The floating frame of reference leaves these forces out. Made at the first look. Floor: analysis.
!> Source: doc/theory, section 43, eqs. (V3)-(V5).
!>
!>     call start_membrane(self, system, work, surveys, own, q)   ! allocates; the state gives the directions of the joints
!>     call find_membrane(self, survey, eta)                      ! self%force of each element, self%push on the coordinates
module limber_analysis_membrane
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_analysis_surveys, only: surveys_type, body_survey_type, is_base
   use limber_flex_frame, only: frame_type, own_displacements
   use limber_flex_frame_solver, only: solve_static
   use limber_flex_survey, only: survey_type
   use limber_system_algebra, only: cross
   use limber_system_point_motion, only: point_position
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: membrane_type, start_membrane, find_membrane

   !> The constants of one frame, and what was found last
   type :: membrane_type
      !> Whether the constants are made, and whether anything can hold the ends of members apart
      logical :: made = .false., redundant = .false.
      !> Force of each joint with the ground on the nodes, and the displacements that it makes (3, nodes, rows)
      real(wp), allocatable :: load(:, :, :), response(:, :, :)
      !> Of the equations of these forces and of the motion of the body: the inverse (rows + 3, rows + 3)
      real(wp), allocatable :: inverse(:, :)
      !> Axial force of each element that the shortening makes (elements) [force]
      real(wp), allocatable :: force(:)
      !> Work of these forces on the slopes that the rotation of the body (0) and the chosen coordinates make (0:chosen)
      real(wp), allocatable :: push(:)
      !> Scratch: displacements of the coordinates, others, forces (3, nodes), right-hand side and forces of joints (rows + 3),
      !> shortening (elements)
      real(wp), allocatable :: bent(:, :), u(:, :), nodal(:, :), side(:), lambda(:), strain(:)
   end type membrane_type

   !> Part of the largest eigenvalue below which equations depend on each other
   real(wp), parameter :: dependent = 1.0e-11_wp

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
      real(wp) :: rigid(3, system%nc)
      integer :: rows, loops, i
      self%made = .true.
      associate (survey => own%survey, mesh => own%survey%mesh)
         allocate (self%load(3, size(mesh%place, 2), system%nc))
         call find_joints(self, system, work, surveys, own, q, rows, rigid)
         loops = size(mesh%member) - size(mesh%place, 2) + 1
         self%redundant = loops > 0 .or. rows > 3 .or. count(.not. mesh%free) > 3
         if (.not. self%redundant) return
         allocate (self%response(3, size(mesh%place, 2), rows))
         do i = 1, rows
            self%load(:, :, i) = merge(self%load(:, :, i), 0.0_wp, mesh%free)
            call solve_static(mesh, survey%solver, self%load(:, :, i), self%response(:, :, i))
         end do
         call invert(self, rows, rigid(:, :rows))
         allocate (self%force(size(mesh%member)), self%strain(size(mesh%member)), self%push(0:size(survey%chosen)))
         allocate (self%bent(3, size(mesh%place, 2)), self%u(3, size(mesh%place, 2)), self%nodal(3, size(mesh%place, 2)))
         allocate (self%side(rows + 3), self%lambda(rows + 3))
      end associate
   end subroutine start_membrane

   !> The forces of joints with the ground and with rigid bodies of known motion, for unit multipliers: on the nodes, and on the
   !> motion of the body.
   subroutine find_joints(self, system, work, surveys, own, q, rows, rigid)
      type(membrane_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(surveys_type), intent(in) :: surveys
      type(body_survey_type), intent(in) :: own
      real(wp), intent(in) :: q(:)
      !> How many
      integer, intent(out) :: rows
      !> Along both axes of the body, and about its origin (3, rows)
      real(wp), intent(out) :: rigid(:, :)
      real(wp) :: force(3), arm(2)
      integer :: i, side, row, first, place, point
      first = system%layout%q(own%body)
      rows = 0
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item, u => q(first + 2:first + 3))
            do side = 1, 2
               if (item%bodies(side) /= own%body .or. .not. is_base(system, item%bodies(3 - side))) cycle
               point = item%points(side)
               do row = 1, item%rows
                  rows = rows + 1
                  force = work%jacobians(side, i)%z(row, 1:3)
                  rigid(:, rows) = [dot_product(u, force(1:2)), cross(u, force(1:2)), force(3)]
                  self%load(:, :, rows) = 0.0_wp
                  if (point == 0) cycle
                  place = surveys%place(point)
                  if (place == 0) cycle
                  arm = point_position(system%model, system%layout, system%model%points(point), q) - q(first:first + 1)
                  self%load(:, :, rows) = rigid(1, rows)*own%survey%load(:, :, 3*place - 2) &
                     & + rigid(2, rows)*own%survey%load(:, :, 3*place - 1) &
                     & + (force(3) - cross(arm, force(1:2)))*own%survey%load(:, :, 3*place)
               end do
            end do
         end associate
      end do
   end subroutine find_joints

   !> Inverse of the equations of the joints' forces and of the motion of the body, eq. (V4); equations that depend on others
   !> take no part.
   subroutine invert(self, rows, rigid)
      type(membrane_type), intent(inout) :: self
      integer, intent(in) :: rows
      !> (3, rows)
      real(wp), intent(in) :: rigid(:, :)
      real(wp) :: matrix(rows + 3, rows + 3), scale(rows + 3), value(rows + 3), room(8*(rows + 3)), size_of
      integer :: i, j, info
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
      do j = rows + 1, rows + 3
         size_of = norm2(scale(:rows)*matrix(:rows, j))
         if (size_of > 0.0_wp) scale(j) = 1/size_of
      end do
      do j = 1, rows + 3
         matrix(:, j) = scale*matrix(:, j)*scale(j)
      end do
      call dsyev('V', 'L', rows + 3, matrix, rows + 3, value, room, size(room), info)
      allocate (self%inverse(rows + 3, rows + 3))
      self%inverse = 0.0_wp
      if (info /= 0) return
      do i = 1, rows + 3
         if (.not. abs(value(i)) > dependent*maxval(abs(value))) cycle
         do j = 1, rows + 3
            self%inverse(:, j) = self%inverse(:, j) + scale*matrix(:, i)*(matrix(j, i)*scale(j)/value(i))
         end do
      end do
   end subroutine invert

   !> The axial forces that the shortening of a state makes, eqs. (V3), (V4), and their work on slopes.
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

   !> Geometric stiffness of an element of length l under unit tension, eq. (17), times (w, theta) of both ends.
   pure function tension_times(own, l) result(force)
      real(wp), intent(in) :: own(4), l
      real(wp) :: force(4), tilt
      tilt = (own(3) - own(1))/l
      force(3) = 1.2_wp*tilt - 0.1_wp*(own(2) + own(4))
      force(1) = -force(3)
      force(2) = l*((4*own(2) - own(4))/30 - 0.1_wp*tilt)
      force(4) = l*((4*own(4) - own(2))/30 - 0.1_wp*tilt)
   end function tension_times

end module limber_analysis_membrane
