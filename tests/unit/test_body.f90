!> Inertia of one body against sums over its nodes, each node a mass point whose position r + R(theta) (p0 + phi eta) is
!> written with an angle: not with the polynomials of the program. Synthetic bodies have nodes anywhere in the plane and shapes
!> in both directions, so that no term vanishes by symmetry. Nodes that spin have a rotary inertia and a rotation for each shape.
program test_body
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: beam_type, displacement_field_type, new_support
   use limber_beam_reduced_body, only: add_inertia, add_rotary, reduced_type, rigid_reduced, start_inertia
   use limber_beam_beam_reduction, only: fidelity_linear, reduce_beam, reduction_type
   use limber_multibody_body, only: body_mass, centre_moment, gravity_forces, kinetic_energy, velocity_forces, weight_potential
   use scenes, only: derivative, random, second_derivative
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: gravity(2) = [1.7_wp, -9.2_wp]

   !> A body as mass points
   type :: cloud_type
      !> Mass, undeformed place (2) and displacement for each coordinate (2,n) of each node
      real(wp), allocatable :: mass(:), p0(:, :), phi(:, :, :)
      !> Rotary inertia of each node, and its rotation for each coordinate (n); unallocated if none has any
      real(wp), allocatable :: spin(:), psi(:, :)
   end type cloud_type

   !> A state: angle, velocities, and coordinates
   type :: motion_type
      real(wp) :: position(2), angle, velocity(2), omega, acceleration(2), alpha
      real(wp), allocatable :: eta(:), rate(:), push(:)
   end type motion_type

   type(cloud_type) :: cloud
   type(reduced_type) :: body
   integer :: trial

   do trial = 1, 4
      call synthetic(9, trial + 1, .false., cloud, body)
      call test_all(cloud, body, 'synthetic')
      call synthetic(9, trial + 1, .true., cloud, body)
      call test_all(cloud, body, 'spinning')
   end do
   call from_beam('PINNED-ROLLER', cloud, body)
   call test_all(cloud, body, 'pinned beam')
   call from_beam('CLAMPED-FREE', cloud, body)
   call test_all(cloud, body, 'clamped beam')
   call from_beam('FREE-FREE', cloud, body)
   call test_all(cloud, body, 'free beam')
   call rigid(cloud, body)
   call test_all(cloud, body, 'rigid')
   call finish()

contains

   !> Random nodes; shapes made orthonormal in the mass, bending and axial in one.
   subroutine synthetic(nodes, n, spins, cloud, body)
      integer, intent(in) :: nodes, n
      !> Whether nodes have a rotary inertia
      logical, intent(in) :: spins
      type(cloud_type), intent(out) :: cloud
      type(reduced_type), intent(out) :: body
      integer :: i, j, k, pass
      real(wp) :: part
      allocate (cloud%mass(nodes), cloud%p0(2, nodes), cloud%phi(2, n, nodes), cloud%spin(nodes), cloud%psi(n, nodes))
      cloud%spin = 0.0_wp
      do i = 1, nodes
         cloud%mass(i) = 1.2_wp + random()
         cloud%p0(:, i) = [random() + 0.4_wp, random() - 0.3_wp]
         do j = 1, n
            cloud%phi(:, j, i) = [random(), random()]
            cloud%psi(j, i) = random()
         end do
         if (spins) cloud%spin(i) = 1.1_wp + random()
      end do
      do j = 1, n
         do pass = 1, 2
            do k = 1, j - 1
               part = product_of(cloud, j, k)
               cloud%phi(:, j, :) = cloud%phi(:, j, :) - part*cloud%phi(:, k, :)
               cloud%psi(j, :) = cloud%psi(j, :) - part*cloud%psi(k, :)
            end do
         end do
         part = sqrt(product_of(cloud, j, j))
         cloud%phi(:, j, :) = cloud%phi(:, j, :)/part
         cloud%psi(j, :) = cloud%psi(j, :)/part
      end do
      call start_inertia(body, n)
      do i = 1, nodes
         call add_inertia(body, cloud%mass(i), cloud%p0(:, i), cloud%phi(:, :, i))
         if (spins) call add_rotary(body, cloud%spin(i), cloud%psi(:, i))
      end do
   end subroutine synthetic

   !> Product of two shapes in the mass.
   pure real(wp) function product_of(cloud, j, k)
      type(cloud_type), intent(in) :: cloud
      integer, intent(in) :: j, k
      product_of = sum(cloud%mass*(cloud%phi(1, j, :)*cloud%phi(1, k, :) + cloud%phi(2, j, :)*cloud%phi(2, k, :))) &
         & + sum(cloud%spin*cloud%psi(j, :)*cloud%psi(k, :))
   end function product_of

   !> A real beam, its nodes with half an element's mass from either side.
   subroutine from_beam(support, cloud, body)
      character(*), intent(in) :: support
      type(cloud_type), intent(out) :: cloud
      type(reduced_type), intent(out) :: body
      type(beam_type), parameter :: beam = beam_type(ea=2.0e4_wp, ei=3.0_wp, rho_a=0.8_wp, length=1.3_wp, elements=10)
      real(wp), parameter :: origin = 0.4_wp
      type(reduction_type) :: choice
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      integer :: i
      choice = reduction_type(support=new_support(support), bending=3, axial=2, geometric_elements=2, &
         & fidelity=fidelity_linear, origin=origin)
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, support)
      allocate (cloud%mass(0:beam%elements), cloud%p0(2, 0:beam%elements), cloud%phi(2, body%n, 0:beam%elements))
      cloud%mass = beam%rho_a*beam%length/beam%elements
      cloud%mass([0, beam%elements]) = cloud%mass([0, beam%elements])/2
      cloud%phi = 0.0_wp
      do i = 0, beam%elements
         cloud%p0(:, i) = [beam%length*i/beam%elements - origin, 0.0_wp]
         cloud%phi(2, :3, i) = field%w(i, :)
         cloud%phi(1, 4:, i) = field%u(i, :)
      end do
   end subroutine from_beam

   !> Two mass points for a rigid body of the same mass, centre and inertia.
   subroutine rigid(cloud, body)
      type(cloud_type), intent(out) :: cloud
      type(reduced_type), intent(out) :: body
      body = rigid_reduced(3.0_wp, 0.75_wp, [0.4_wp, -0.2_wp])
      allocate (cloud%mass(2), cloud%p0(2, 2), cloud%phi(2, 0, 2))
      cloud%mass = 1.5_wp
      cloud%p0(:, 1) = [0.7_wp, 0.2_wp]
      cloud%p0(:, 2) = [0.1_wp, -0.6_wp]
   end subroutine rigid

   !> A random state; deflections as large as the body.
   function random_motion(n) result(motion)
      integer, intent(in) :: n
      type(motion_type) :: motion
      integer :: i
      motion%position = [random(), random()]
      motion%angle = 3*random()
      motion%velocity = [random(), random()]
      motion%omega = 2*random()
      motion%acceleration = [random(), random()]
      motion%alpha = 2*random()
      motion%eta = [(random(), i=1, n)]
      motion%rate = [(random(), i=1, n)]
      motion%push = [(random(), i=1, n)]
   end function random_motion

   !> Position of a node at a time near the state: every coordinate moves with constant acceleration.
   pure function place(cloud, motion, i, t) result(x)
      type(cloud_type), intent(in) :: cloud
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: i
      real(wp), intent(in) :: t
      real(wp) :: x(2)
      x = motion%position + motion%velocity*t + motion%acceleration*t**2/2 &
         & + rotated(motion%angle + motion%omega*t + motion%alpha*t**2/2, &
         & cloud%p0(:, i) + matmul(cloud%phi(:, :, i), motion%eta + motion%rate*t + motion%push*t**2/2))
   end function place

   pure function rotated(angle, p) result(x)
      real(wp), intent(in) :: angle, p(2)
      real(wp) :: x(2)
      x = [cos(angle)*p(1) - sin(angle)*p(2), sin(angle)*p(1) + cos(angle)*p(2)]
   end function rotated

   !> How a node moves with (r, theta, eta): (2, 3 + n).
   pure function node_jacobian(cloud, motion, i) result(jacobian)
      type(cloud_type), intent(in) :: cloud
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: i
      real(wp) :: jacobian(2, 3 + size(motion%eta))
      real(wp), parameter :: right_angle = acos(0.0_wp)
      integer :: k
      jacobian(:, 1) = [1.0_wp, 0.0_wp]
      jacobian(:, 2) = [0.0_wp, 1.0_wp]
      jacobian(:, 3) = rotated(motion%angle + right_angle, &
         & cloud%p0(:, i) + matmul(cloud%phi(:, :, i), motion%eta))
      do k = 1, size(motion%eta)
         jacobian(:, 3 + k) = rotated(motion%angle, cloud%phi(:, k, i))
      end do
   end function node_jacobian

   !> How the rotation of a node changes with (r, theta, eta): (3 + n).
   pure function spin_row(cloud, motion, i) result(row)
      type(cloud_type), intent(in) :: cloud
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: i
      real(wp) :: row(3 + size(motion%eta))
      row(:3) = [0.0_wp, 0.0_wp, 1.0_wp]
      row(4:) = cloud%psi(:, i)
   end function spin_row

   subroutine test_all(cloud, body, name)
      type(cloud_type), intent(in) :: cloud
      type(reduced_type), intent(in) :: body
      character(*), intent(in) :: name
      integer :: round
      do round = 1, 4
         call test_inertia(cloud, body, random_motion(body%n), name)
         call test_energy(cloud, body, random_motion(body%n), name)
         call test_weight(cloud, body, random_motion(body%n), name)
      end do
   end subroutine test_all

   !> Mass matrix, and inertia forces from accelerations of the nodes by a stencil along the motion.
   subroutine test_inertia(cloud, body, motion, name)
      type(cloud_type), intent(in) :: cloud
      type(reduced_type), intent(in) :: body
      type(motion_type), intent(in) :: motion
      character(*), intent(in) :: name
      real(wp) :: mass(3 + body%n, 3 + body%n), own(3 + body%n, 3 + body%n), jacobian(2, 3 + body%n), u(2)
      real(wp) :: frame(3, 3), coupling(body%n, 3), on_frame(3), on_eta(body%n), force(3 + body%n), inertia(3 + body%n)
      real(wp) :: acceleration(2), closed(2), p(2), drift(2), push(2), scale, row(3 + body%n)
      ! The stencil errs by h^4 = 1e-9 of a fourth derivative and by round-off 1e-16/h^2 = 1e-11
      real(wp), parameter :: h = 5.0e-3_wp
      integer :: i, k
      u = [cos(motion%angle), sin(motion%angle)]
      call body_mass(body, u, motion%eta, frame, coupling)
      mass = 0.0_wp
      mass(:3, :3) = frame
      mass(4:, :3) = coupling
      mass(:3, 4:) = transpose(coupling)
      do k = 1, body%n
         mass(3 + k, 3 + k) = 1.0_wp
      end do
      on_frame = 1.0_wp
      on_eta = 1.0_wp
      call velocity_forces(body, u, motion%omega, motion%eta, motion%rate, on_frame, on_eta)
      force = matmul(mass, [motion%acceleration, motion%alpha, motion%push]) - ([on_frame, on_eta] - 1.0_wp)

      own = 0.0_wp
      inertia = 0.0_wp
      do i = lbound(cloud%mass, 1), ubound(cloud%mass, 1)
         jacobian = node_jacobian(cloud, motion, i)
         own = own + cloud%mass(i)*matmul(transpose(jacobian), jacobian)
         ! u'' = alpha J u - omega^2 u and the Coriolis term, eq. (1.6)
         p = cloud%p0(:, i) + matmul(cloud%phi(:, :, i), motion%eta)
         drift = matmul(cloud%phi(:, :, i), motion%rate)
         push = matmul(cloud%phi(:, :, i), motion%push)
         closed = motion%acceleration + rotated(motion%angle, push - motion%omega**2*p &
            & + motion%alpha*[-p(2), p(1)] + 2*motion%omega*[-drift(2), drift(1)])
         acceleration = second_derivative(place(cloud, motion, i, -2*h), place(cloud, motion, i, -h), &
            & place(cloud, motion, i, 0.0_wp), place(cloud, motion, i, h), place(cloud, motion, i, 2*h), h)
         call check(maxval(abs(acceleration - closed)) <= 1.0e-7_wp*(1 + maxval(abs(closed))), &
            & name//': the acceleration of a node by differences')
         inertia = inertia + cloud%mass(i)*matmul(transpose(jacobian), closed)
         if (.not. allocated(cloud%spin)) cycle
         row = spin_row(cloud, motion, i)
         do k = 1, size(row)
            own(:, k) = own(:, k) + cloud%spin(i)*row*row(k)
         end do
         inertia = inertia + cloud%spin(i)*row*dot_product(row, [motion%acceleration, motion%alpha, motion%push])
      end do
      scale = maxval(abs(own))
      call check(maxval(abs(frame - transpose(frame))) <= 0.0_wp, name//': the frame''s mass matrix is symmetric')
      call check(maxval(abs(own - mass)) <= 1.0e-11_wp*scale, name//': mass matrix')
      call check(maxval(abs(inertia - force)) <= 1.0e-11_wp*(scale + maxval(abs(inertia))), name//': inertia forces')
      call check(maxval(abs([on_frame, on_eta] - 1.0_wp)) > 1.0e-3_wp, name//': there are velocity terms')
   end subroutine test_inertia

   !> Kinetic energy, and the sign of E: the momentum of eta by differences of the energy of the mass points.
   subroutine test_energy(cloud, body, motion, name)
      type(cloud_type), intent(in) :: cloud
      type(reduced_type), intent(in) :: body
      type(motion_type), intent(in) :: motion
      character(*), intent(in) :: name
      real(wp) :: u(2), own, velocity(2), x(2, -2:2), frame(3, 3), coupling(body%n, 3), momentum(3 + body%n), value(-2:2)
      real(wp), parameter :: h = 1.0e-3_wp
      type(motion_type) :: other
      integer :: i, k, step
      u = [cos(motion%angle), sin(motion%angle)]
      own = energy_of(cloud, motion)
      call check_close(kinetic_energy(body, u, motion%eta, motion%velocity, motion%omega, motion%rate), own, 1.0e-12_wp*own, &
         & name//': kinetic energy')
      ! The energy again with velocities of the nodes by differences of their places
      own = 0.0_wp
      do i = lbound(cloud%mass, 1), ubound(cloud%mass, 1)
         do step = -2, 2
            x(:, step) = place(cloud, motion, i, step*h)
         end do
         velocity = derivative(x(:, -2), x(:, -1), x(:, 1), x(:, 2), h)
         own = own + 0.5_wp*cloud%mass(i)*dot_product(velocity, velocity)
         if (allocated(cloud%spin)) own = own + 0.5_wp*cloud%spin(i)*dot_product(spin_row(cloud, motion, i), &
            & [motion%velocity, motion%omega, motion%rate])**2
      end do
      call check_close(kinetic_energy(body, u, motion%eta, motion%velocity, motion%omega, motion%rate), own, 1.0e-8_wp*own, &
         & name//': kinetic energy by differences')
      ! dT/d(rates) = M rates; the energy is quadratic in the rates, for which the stencil is exact
      call body_mass(body, u, motion%eta, frame, coupling)
      momentum(:3) = matmul(frame, [motion%velocity, motion%omega]) + matmul(transpose(coupling), motion%rate)
      momentum(4:) = matmul(coupling, [motion%velocity, motion%omega]) + motion%rate
      do k = 1, 3 + body%n
         do step = -2, 2
            other = motion
            if (k <= 2) then
               other%velocity(k) = other%velocity(k) + 0.5_wp*step
            else if (k == 3) then
               other%omega = other%omega + 0.5_wp*step
            else
               other%rate(k - 3) = other%rate(k - 3) + 0.5_wp*step
            end if
            value(step) = energy_of(cloud, other)
         end do
         call check_close(momentum(k), derivative(value(-2), value(-1), value(1), value(2), 0.5_wp), 1.0e-11_wp*maxval(value), &
            & name//': momentum')
      end do
   end subroutine test_energy

   !> Sum of 1/2 m |v|^2 over the nodes.
   pure real(wp) function energy_of(cloud, motion) result(energy)
      type(cloud_type), intent(in) :: cloud
      type(motion_type), intent(in) :: motion
      real(wp) :: velocity(2)
      integer :: i
      energy = 0.0_wp
      do i = lbound(cloud%mass, 1), ubound(cloud%mass, 1)
         velocity = matmul(node_jacobian(cloud, motion, i), [motion%velocity, motion%omega, motion%rate])
         energy = energy + 0.5_wp*cloud%mass(i)*dot_product(velocity, velocity)
         if (allocated(cloud%spin)) energy = energy + 0.5_wp*cloud%spin(i)*dot_product(spin_row(cloud, motion, i), &
            & [motion%velocity, motion%omega, motion%rate])**2
      end do
   end function energy_of

   !> Weight: m g on every node; its potential, and the forces as the potential's slope.
   subroutine test_weight(cloud, body, motion, name)
      type(cloud_type), intent(in) :: cloud
      type(reduced_type), intent(in) :: body
      type(motion_type), intent(in) :: motion
      character(*), intent(in) :: name
      real(wp) :: u(2), own(3 + body%n), on_frame(3), on_eta(body%n), energy, value(-2:2), scale, first(2), x(2), angle
      real(wp), parameter :: h = 2.0e-3_wp
      type(motion_type) :: other
      integer :: i, k, step
      u = [cos(motion%angle), sin(motion%angle)]
      own = 0.0_wp
      energy = 0.0_wp
      first = 0.0_wp
      do i = lbound(cloud%mass, 1), ubound(cloud%mass, 1)
         own = own + cloud%mass(i)*matmul(gravity, node_jacobian(cloud, motion, i))
         x = place(cloud, motion, i, 0.0_wp)
         energy = energy - cloud%mass(i)*dot_product(gravity, x)
         first = first + cloud%mass(i)*(x - motion%position)
      end do
      scale = sum(cloud%mass)*norm2(gravity)*3
      on_frame = 1.0_wp
      on_eta = 1.0_wp
      call gravity_forces(body, gravity, u, motion%eta, on_frame, on_eta)
      call check(maxval(abs([on_frame, on_eta] - 1.0_wp - own)) <= 1.0e-14_wp*scale*10, name//': weight')
      call check_close(weight_potential(body, gravity, motion%position, u, motion%eta), energy, 1.0e-14_wp*scale*10, &
         & name//': potential of the weight')
      call check(maxval(abs(rotated(motion%angle, centre_moment(body, motion%eta)) - first)) <= 1.0e-13_wp*sum(cloud%mass), &
         & name//': first moment')
      do k = 1, 3 + body%n
         do step = -2, 2
            other = motion
            angle = motion%angle
            if (k <= 2) then
               other%position(k) = other%position(k) + step*h
            else if (k == 3) then
               angle = angle + step*h
            else
               other%eta(k - 3) = other%eta(k - 3) + step*h
            end if
            value(step) = weight_potential(body, gravity, other%position, [cos(angle), sin(angle)], other%eta)
         end do
         ! h^4/30 of a fifth derivative and round-off 1e-16/h
         call check_close(-derivative(value(-2), value(-1), value(1), value(2), h), own(k), 1.0e-12_wp*scale, &
            & name//': the weight is the slope of its potential')
      end do
   end subroutine test_weight

end program test_body
