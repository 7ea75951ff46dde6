!> Monitor of the foreshortening of frames: its inertia, and the displacements that it makes. The finite elements of the frame at
!> rest, under the shortening of its elements, as its supports and joints hold it. Made at the first look. Floor: monitor. Source:
!> doc/theory, eqs. (7.24), (7.44)-(7.46).
!>
!>     call start_drawing_in(self, membrane, survey, carried)                    ! allocates
!>     call find_drawing_in(self, survey, eta, rate, acceleration)      ! self%energy, %work, %force
!>     call show_drawing_in(self, body, channels)                                ! channels%field, %inertia
module limber_monitor_drawing_in
   use limber_base_kinds, only: wp
   use limber_monitor_drawn_channels, only: drawn_channels_type
   use limber_monitor_membrane, only: membrane_type, moved_by, tension_times, pull_nodes
   use limber_beam_plane_frame, only: frame_type, own_displacements, unit_load
   use limber_beam_frame_solver, only: solve_static
   use limber_beam_mesh_forces, only: survey_type
   use limber_multibody_plane_vectors, only: cross, turn
   implicit none
   private
   public :: drawing_in_type, start_drawing_in, find_drawing_in, show_drawing_in

   !> Most parts that members are divided into, so that the constants stay small
   integer, parameter :: most = 240

   !> The constants of one frame, and what was found last
   type :: drawing_in_type
      !> Whether the constants are made
      logical :: made = .false.
      !> Part of each element (elements); inertia of the shortening of the parts (parts, parts) [mass]
      integer, allocatable :: part(:)
      real(wp), allocatable :: inertia(:, :)
      !> Shortening of the parts that bending makes, its speed and acceleration (parts) [length, /time, /time^2]
      real(wp), allocatable :: short(:), speed(:), quicker(:)
      !> Twice the kinetic energy of the shortening; work of the axial forces of its inertia on the bending, and the largest of
      !> these forces
      real(wp) :: energy = 0.0_wp, work = 0.0_wp, force = 0.0_wp
      !> Scratch: displacements of the nodes by bending, their rates and accelerations (3, nodes)
      real(wp), allocatable :: bent(:, :), rate(:, :), faster(:, :)
      !> Points whose displacements are asked for, if any are: their slots, members, coordinates along these [length], places in the
      !> frame [length]
      integer, allocatable :: slots(:), member(:)
      real(wp), allocatable :: along(:), place(:, :)
      !> Displacements along both axes of the frame, and rotations, relative to the frame, that a unit shortening of each part
      !> makes at these; and times the masses, with the moment about the origin, of the whole (3, parts, points + 1)
      real(wp), allocatable :: by_part(:, :, :)
   end type drawing_in_type

contains

   !> Makes the constants.
   subroutine start_drawing_in(self, membrane, survey, carried)
      type(drawing_in_type), intent(inout) :: self
      !> How joints hold the frame
      type(membrane_type), intent(in) :: membrane
      type(survey_type), intent(in) :: survey
      !> Masses that other bodies hang on the places of joints and loads (places)
      real(wp), intent(in) :: carried(:)
      real(wp), allocatable :: drawn(:, :), nodal(:, :), u(:, :)
      real(wp) :: length, motion(3)
      integer :: e, i, k, nodes, parts
      self%made = .true.
      associate (mesh => survey%mesh)
         nodes = size(mesh%place, 2)
         call divide(mesh%first, self%part)
         parts = maxval(self%part)
         allocate (drawn(2*nodes + 2*size(carried), parts), nodal(3, nodes), u(3, nodes))
         if (allocated(self%slots)) allocate (self%by_part(3, parts, size(self%slots) + 1))
         do i = 1, parts
            nodal = 0.0_wp
            length = sum(mesh%length, mask=self%part == i)
            do e = 1, size(self%part)
               if (self%part(e) == i) call pull_nodes(mesh, e, mesh%ea(e)/length, nodal)
            end do
            nodal = merge(nodal, 0.0_wp, mesh%free)
            call solve_static(mesh, survey%solver, nodal, u)
            call moved_by(membrane, mesh, u, motion)
            if (allocated(self%slots)) call draw(self, mesh, u, motion, i)
            drawn(:2*nodes, i) = reshape(u(1:2, :)*sqrt(mesh%mass(1:2, :)), [2*nodes])
            do k = 1, size(carried)
               drawn(2*nodes + 2*k - 1, i) = sqrt(carried(k))*sum(survey%load(:, :, 3*k - 2)*u)
               drawn(2*nodes + 2*k, i) = sqrt(carried(k))*sum(survey%load(:, :, 3*k - 1)*u)
            end do
         end do
         self%inertia = matmul(transpose(drawn), drawn)
         allocate (self%short(parts), self%speed(parts), self%quicker(parts))
         allocate (self%bent(3, nodes), self%rate(3, nodes), self%faster(3, nodes))
      end associate
   end subroutine start_drawing_in

   !> What the shortening of a part does at the points, and to the whole.
   subroutine draw(self, mesh, u, motion, part)
      type(drawing_in_type), intent(inout) :: self
      type(frame_type), intent(in) :: mesh
      !> Displacements of the nodes (3, nodes), and the motion of the floating frame in these: along both axes, and rotation
      real(wp), intent(in) :: u(:, :), motion(3)
      integer, intent(in) :: part
      real(wp) :: own(2)
      integer :: i, k
      do i = 1, size(self%slots)
         do k = 1, 3
            self%by_part(k, part, i) = sum(unit_load(mesh, self%member(i), self%along(i), k)*u) - motion(k)
         end do
         self%by_part(1:2, part, i) = self%by_part(1:2, part, i) - motion(3)*turn(self%place(:, i))
      end do
      associate (whole => self%by_part(:, part, size(self%slots) + 1))
         whole = 0.0_wp
         do i = 1, size(u, 2)
            own = mesh%mass(1:2, i)*(u(1:2, i) - motion(1:2) - motion(3)*turn(mesh%place(:, i)))
            whole = whole + [own, cross(mesh%place(:, i), own)]
         end do
      end associate
   end subroutine draw

   !> Displacements at the points in the state that was found last, their rates and accelerations.
   pure subroutine show_drawing_in(self, body, channels)
      type(drawing_in_type), intent(in) :: self
      !> Index of the body
      integer, intent(in) :: body
      type(drawn_channels_type), intent(inout) :: channels
      integer :: i
      do i = 1, size(self%slots)
         channels%field(:, :, self%slots(i)) = of_parts(self%by_part(:, :, i))
      end do
      channels%inertia(:, :, body) = of_parts(self%by_part(:, :, size(self%slots) + 1))

   contains

      pure function of_parts(by_part) result(field)
         real(wp), intent(in) :: by_part(:, :)
         real(wp) :: field(3, 3)
         integer :: k
         field = 0.0_wp
         do k = 1, size(self%short)
            field(:, 1) = field(:, 1) + by_part(:, k)*self%short(k)
            field(:, 2) = field(:, 2) + by_part(:, k)*self%speed(k)
            field(:, 3) = field(:, 3) + by_part(:, k)*self%quicker(k)
         end do
      end function of_parts

   end subroutine show_drawing_in

   !> Divides each member into parts of some elements.
   pure subroutine divide(first, part)
      !> First element of each member, and one behind the last (members + 1)
      integer, intent(in) :: first(:)
      integer, allocatable, intent(out) :: part(:)
      integer :: m, e, count, each, made
      allocate (part(first(size(first)) - 1))
      each = max(1, most/(size(first) - 1))
      made = 0
      do m = 1, size(first) - 1
         count = first(m + 1) - first(m)
         do e = 1, count
            part(first(m) + e - 1) = made + 1 + ((e - 1)*min(each, count))/count
         end do
         made = part(first(m + 1) - 1)
      end do
   end subroutine divide

   !> Energy and work in a state.
   pure subroutine find_drawing_in(self, survey, eta, rate, acceleration)
      type(drawing_in_type), intent(inout) :: self
      type(survey_type), intent(in) :: survey
      !> Coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: eta(:), rate(:), acceleration(:)
      real(wp) :: own(6), pull(4), moving(6), changing(6), row(2)
      integer :: i, k
      self%bent = 0.0_wp
      self%rate = 0.0_wp
      self%faster = 0.0_wp
      ! All coordinates bend the members: those that stretch them mostly may take back what others do
      do k = 1, size(eta)
         self%bent = self%bent + survey%shape(:, :, k)*eta(k)
         self%rate = self%rate + survey%shape(:, :, k)*rate(k)
         self%faster = self%faster + survey%shape(:, :, k)*acceleration(k)
      end do
      self%short = 0.0_wp
      self%speed = 0.0_wp
      self%quicker = 0.0_wp
      associate (mesh => survey%mesh)
         do i = 1, size(mesh%member)
            own = own_displacements(mesh, i, self%bent)
            moving = own_displacements(mesh, i, self%rate)
            changing = own_displacements(mesh, i, self%faster)
            pull = tension_times(own([2, 3, 5, 6]), mesh%length(i))
            k = self%part(i)
            self%short(k) = self%short(k) + 0.5_wp*dot_product(own([2, 3, 5, 6]), pull)
            self%speed(k) = self%speed(k) + dot_product(moving([2, 3, 5, 6]), pull)
            self%quicker(k) = self%quicker(k) + dot_product(changing([2, 3, 5, 6]), pull) &
               & + dot_product(moving([2, 3, 5, 6]), tension_times(moving([2, 3, 5, 6]), mesh%length(i)))
         end do
      end associate
      self%energy = 0.0_wp
      self%work = 0.0_wp
      self%force = 0.0_wp
      do i = 1, size(self%short)
         row = 0.0_wp
         do k = 1, size(self%short)
            row = row + self%inertia(k, i)*[self%speed(k), self%quicker(k)]
         end do
         self%energy = self%energy + self%speed(i)*row(1)
         self%work = self%work + 2*self%short(i)*row(2)
         self%force = max(self%force, abs(row(2)))
      end do
   end subroutine find_drawing_in

end module limber_monitor_drawing_in
