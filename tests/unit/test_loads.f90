!> Loads: forces against the energy that is stored, derivatives against differences of the forces, power against the rate of
!> the energy, for every pairing of bodies; springs whose points meet.
program test_loads
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_model_model, only: ground, model_type
   use limber_multibody_equations_of_motion, only: accelerations, input_power, linearise, mechanical_energy
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent, only: combine, new_tangent, tangent_type
   use limber_multibody_tangent_products, only: times_stiffness
   use scenes, only: add_beam, add_beam_place, add_force, add_place, add_point_mass, add_rigid, add_spring, add_torque, &
      & derivative, empty_model, random, wavy_law
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   real(wp), parameter :: h = 1.0e-3_wp, t = 0.3_wp

   call test_forces()
   call test_tangents()
   call test_whole_tangent()
   call test_power()
   call test_reaction()
   call test_meeting()
   call test_constant_pull()
   call finish()

contains

   !> Springs between all kinds of bodies, torques on two of them, forces on three; no joints.
   function zoo(damping) result(model)
      !> Of every spring
      real(wp), intent(in) :: damping
      type(model_type) :: model
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: rod, arm, block, bead, a, b, c, d, e, f, g
      model = empty_model(1.5_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1, geometric_elements=2, &
         & fidelity=fidelity_kg)
      rod = add_beam(model, 'rod', beam, choice, [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'rod')
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, geometric_elements=3, &
         & fidelity=fidelity_linear, origin=0.3_wp)
      arm = add_beam(model, 'arm', beam, choice, [-0.3_wp, 0.7_wp], -1.1_wp, error)
      call check_no_error(error, 'arm')
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      a = add_beam_place(model, 'rod.end', rod, 1.2_wp)
      b = add_beam_place(model, 'rod.middle', rod, 0.55_wp)
      c = add_beam_place(model, 'arm.tip', arm, 1.2_wp)
      d = add_place(model, 'block.corner', block, [-0.4_wp, 0.25_wp])
      e = add_place(model, 'bead.origin', bead, [0.0_wp, 0.0_wp])
      f = add_place(model, 'ground.a', ground, [2.3_wp, -1.6_wp])
      g = add_place(model, 'block.origin', block, [0.0_wp, 0.0_wp])
      call add_spring(model, a, c, 30.0_wp, 0.7_wp, damping)
      call add_spring(model, b, f, 20.0_wp, 0.0_wp, damping)
      call add_spring(model, f, d, 15.0_wp, 3.0_wp, damping)
      call add_spring(model, d, e, 25.0_wp, 0.4_wp, damping)
      call add_spring(model, e, c, 10.0_wp, 0.0_wp, damping)
      call add_spring(model, a, b, 40.0_wp, 0.5_wp, damping)
      call add_spring(model, f, e, 5.0_wp, 0.2_wp, damping)
      call add_spring(model, g, b, 12.0_wp, 0.1_wp, damping)
      call add_torque(model, block, wavy_law(0.7_wp, 0.3_wp, 2.0_wp, 3.0_wp))
      call add_torque(model, arm, wavy_law(-1.7_wp, 0.0_wp, 1.0_wp, 2.0_wp))
      call add_force(model, b, wavy_law(0.2_wp, 0.1_wp, 2.0_wp, 3.0_wp), wavy_law(-1.0_wp, 0.0_wp, 1.0_wp, 2.0_wp))
      call add_force(model, d, wavy_law(3.0_wp, 0.0_wp, 0.0_wp, 1.0_wp), wavy_law(0.5_wp, 0.0_wp, 0.0_wp, 1.0_wp))
      call add_force(model, e, wavy_law(1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp), wavy_law(2.5_wp, 0.0_wp, 0.0_wp, 1.0_wp))
   end function zoo

   !> A system with a random state, deflections of a tenth of the length.
   subroutine prepare(model, system, work, q, w)
      type(model_type), intent(in) :: model
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      !> Coordinates (nq), independent rates (nw)
      real(wp), allocatable, intent(out) :: q(:), w(:)
      integer :: i, k, first
      real(wp) :: angle
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), w(system%layout%nw))
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         q(first:first + 1) = [random(), random()]
         if (.not. system%layout%framed(i)) cycle
         angle = 3*random()
         q(first + 2:first + 3) = [cos(angle), sin(angle)]
         do k = 1, system%layout%n(i)
            q(first + 3 + k) = 0.1_wp*random()
         end do
      end do
      do k = 1, size(w)
         w(k) = random()
      end do
   end subroutine prepare

   !> Kinematics at coordinates and rates that are moved by a step along one of the latter's places.
   subroutine place(system, work, q, w, index, dx, dw)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:)
      !> Place among the rates, and by how much the coordinate and the rate are moved
      integer, intent(in) :: index
      real(wp), intent(in) :: dx, dw
      real(wp) :: moved(size(q)), v(size(q)), change(size(w)), rate(size(w))
      change = 0.0_wp
      change(index) = dx
      rate = w
      rate(index) = rate(index) + dw
      call advance(system%layout, q, change, moved)
      call velocities_of(system%layout, moved, rate, v)
      call place_frames(system%model, system%layout, t, moved, work%kinematics)
      call move_frames(system%model, system%layout, moved, v, work%kinematics)
   end subroutine place

   !> Places of a load's stacked rates among all.
   function unknowns_of(system, load) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: load
      integer, allocatable :: list(:)
      integer :: side, k
      allocate (list(0))
      associate (item => system%loads(load)%item)
         do side = 1, size(item%bodies)
            if (item%bodies(side) == ground) cycle
            list = [list, (system%layout%w(item%bodies(side)) + k - 1, k=1, item%rates(side))]
         end do
      end associate
   end function unknowns_of

   !> What no damper and no law in time does is the gradient of the energy.
   subroutine test_forces()
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), w(:), force(:)
      real(wp) :: energy(-2:2), total, power
      integer, allocatable :: unknowns(:)
      integer :: i, j, k, m
      call prepare(zoo(0.0_wp), system, work, q, w)
      call check(size(system%loads) == 16, 'all loads are there')
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item)
            call check(load%powered .neqv. i <= 8, 'what puts power in')
            if (load%powered) cycle
            unknowns = unknowns_of(system, i)
            allocate (force(size(unknowns)))
            force = 1.0_wp
            call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
            call load%add_force(work%kinematics, force)
            force = force - 1.0_wp
            power = 0.5_wp
            call load%add_power(work%kinematics, power)
            call check_close(power, 0.5_wp, 0.0_wp, 'a spring without damper puts nothing in')
            do j = 1, size(unknowns)
               do k = -2, 2
                  call place(system, work, q, w, unknowns(j), k*h, 0.0_wp)
                  energy(k) = 0.0_wp
                  call load%add_energy(work%kinematics, energy(k))
               end do
               ! Of a body that the spring holds at both ends
               total = 0.0_wp
               do m = 1, size(unknowns)
                  if (unknowns(m) == unknowns(j)) total = total + force(m)
               end do
               call check_close(derivative(energy(-2), energy(-1), energy(1), energy(2), h), -total, &
                  & 1.0e-8_wp*(1 + abs(total)), 'force of a spring')
            end do
            call check(energy(0) > 0.0_wp .and. maxval(abs(force)) > 0.1_wp, 'a spring pulls')
            deallocate (force)
         end associate
      end do
   end subroutine test_forces

   !> Derivatives of the forces by coordinates and by rates.
   subroutine test_tangents()
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), w(:), force(:, :), stiffness(:, :), damping(:, :), sum_k(:), sum_d(:)
      integer, allocatable :: unknowns(:)
      integer :: i, j, k, m
      call prepare(zoo(3.0_wp), system, work, q, w)
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item)
            call check(load%powered, 'a damper takes power')
            unknowns = unknowns_of(system, i)
            m = size(unknowns)
            allocate (force(m, -2:2), stiffness(m, m), damping(m, m), sum_k(m), sum_d(m))
            call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
            stiffness = 0.0_wp
            damping = 0.0_wp
            call load%add_tangent(work%kinematics, stiffness, damping)
            do j = 1, m
               sum_k = 0.0_wp
               sum_d = 0.0_wp
               do k = 1, m
                  if (unknowns(k) /= unknowns(j)) cycle
                  sum_k = sum_k + stiffness(:, k)
                  sum_d = sum_d + damping(:, k)
               end do
               force = 0.0_wp
               do k = -2, 2
                  call place(system, work, q, w, unknowns(j), k*h, 0.0_wp)
                  call load%add_force(work%kinematics, force(:, k))
               end do
               call check(maxval(abs(derivative(force(:, -2), force(:, -1), force(:, 1), force(:, 2), h) + sum_k)) &
                  & <= 1.0e-7_wp*(1 + maxval(abs(stiffness))), 'stiffness of a load')
               force = 0.0_wp
               do k = -2, 2
                  call place(system, work, q, w, unknowns(j), 0.0_wp, k*h)
                  call load%add_force(work%kinematics, force(:, k))
               end do
               call check(maxval(abs(derivative(force(:, -2), force(:, -1), force(:, 1), force(:, 2), h) + sum_d)) &
                  & <= 1.0e-9_wp*(1 + maxval(abs(damping))), 'damping of a load')
            end do
            deallocate (force, stiffness, damping, sum_k, sum_d)
         end associate
      end do
   end subroutine test_tangents

   !> The loads stand where they belong in the matrix of the whole.
   subroutine test_whole_tangent()
      type(system_type) :: system
      type(workspace_type) :: work
      type(tangent_type) :: tangent
      real(wp), allocatable :: q(:), w(:), a(:), v(:), residual(:, :), matrix(:, :), x(:), product(:)
      real(wp), parameter :: m = 2.0_wp, d = 0.3_wp, s = 0.7_wp
      real(wp) :: none(0)
      integer :: j, k, n
      logical :: singular
      call prepare(zoo(3.0_wp), system, work, q, w)
      n = size(w)
      call new_tangent(system, tangent)
      allocate (a(n), v(size(q)), residual(n, -2:2), matrix(n, n), x(n), product(n))
      do j = 1, n
         a(j) = random()
         x(j) = random()
      end do
      matrix = 0.0_wp
      do j = 1, n
         do k = -2, 2
            call residual_at(system, work, q, w, a, j, k*h, 0.0_wp, 0.0_wp, residual(:, k))
         end do
         matrix(:, j) = derivative(residual(:, -2), residual(:, -1), residual(:, 1), residual(:, 2), h)
      end do
      call residual_at(system, work, q, w, a, 1, 0.0_wp, 0.0_wp, 0.0_wp, residual(:, 0))
      call velocities_of(system%layout, q, w, v)
      call linearise_motion(system, work, tangent, q, v, a, none)
      product = 0.0_wp
      call times_stiffness(system, tangent, 1.0_wp, x, product)
      call check(maxval(abs(product - matmul(matrix, x))) <= 1.0e-7_wp*maxval(abs(matrix)), 'product with the stiffness')
      matrix = s*matrix
      do j = 1, n
         do k = -2, 2
            call residual_at(system, work, q, w, a, j, 0.0_wp, k*h, 0.0_wp, residual(:, k))
         end do
         matrix(:, j) = matrix(:, j) + d*derivative(residual(:, -2), residual(:, -1), residual(:, 1), residual(:, 2), h)
         call residual_at(system, work, q, w, a, j, 0.0_wp, 0.0_wp, -0.5_wp, residual(:, -1))
         call residual_at(system, work, q, w, a, j, 0.0_wp, 0.0_wp, 0.5_wp, residual(:, 1))
         matrix(:, j) = matrix(:, j) + m*(residual(:, 1) - residual(:, -1))
      end do
      call combine(tangent, m, d, s, 1.0_wp)
      call tangent%matrix%factor(singular)
      call check(.not. singular, 'the matrix is regular')
      product = matmul(matrix, x)
      call tangent%matrix%solve(product)
      call check_close(maxval(abs(product - x)), 0.0_wp, 1.0e-7_wp, 'solution with the whole matrix')
   end subroutine test_whole_tangent

   !> Residual of the motion with one coordinate, rate and acceleration moved.
   subroutine residual_at(system, work, q, w, a, index, dx, dw, da, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:), a(:)
      integer, intent(in) :: index
      real(wp), intent(in) :: dx, dw, da
      real(wp), intent(inout) :: motion(:)
      real(wp) :: change(size(w)), rate(size(w)), push(size(w)), moved(size(q)), v(size(q)), none(0), empty(0)
      change = 0.0_wp
      change(index) = dx
      rate = w
      rate(index) = rate(index) + dw
      push = a
      push(index) = push(index) + da
      call advance(system%layout, q, change, moved)
      call velocities_of(system%layout, moved, rate, v)
      call motion_residual(system, work, t, moved, v, push, none, motion, empty)
   end subroutine residual_at

   !> The power put in, less what the dampers take, is the rate of the energy along q + v t + a t^2/2.
   subroutine test_power()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), w(:), v(:), a(:)
      real(wp), parameter :: step = 3.0e-6_wp
      real(wp) :: energy(-2:2), kinetic, potential, power, scale
      integer :: k, trial
      do trial = 1, 4
         call prepare(zoo(merge(3.0_wp, 0.0_wp, trial > 2)), system, work, q, w)
         call check(system%powered, 'the system is powered')
         allocate (v(size(q)), a(size(q)))
         call velocities_of(system%layout, q, w, v)
         call linearise(system, work, t, q, error)
         call check_no_error(error, 'free bodies')
         call accelerations(system, work, q, v, a)
         power = input_power(system, work, q, v)
         do k = -2, 2
            call mechanical_energy(system, work, q + v*(k*step) + a*(k*step)**2/2, v + a*(k*step), kinetic, potential)
            energy(k) = kinetic + potential
         end do
         scale = sum(abs(a*v))
         call check_close(derivative(energy(-2), energy(-1), energy(1), energy(2), step), power, &
            & 1.0e-9_wp*scale + 1.0e-15_wp*abs(energy(0))/step, 'power is the rate of the energy')
         call check(abs(power) > 1.0e-2_wp, 'there is power')
         deallocate (v, a)
      end do
   end subroutine test_power

   !> Between two bodies a spring makes no force and no moment in all.
   subroutine test_reaction()
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), w(:), force(:)
      real(wp) :: total(2), moment
      integer :: i, first
      call prepare(zoo(3.0_wp), system, work, q, w)
      call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
      do i = 1, 8
         associate (load => system%loads(i)%item)
            if (any(load%bodies == ground)) cycle
            allocate (force(sum(load%rates)))
            force = 0.0_wp
            call load%add_force(work%kinematics, force)
            first = load%rates(1)
            total = force(1:2) + force(first + 1:first + 2)
            associate (a => work%kinematics%frames(load%bodies(1))%position, b => work%kinematics%frames(load%bodies(2))%position)
               moment = a(1)*force(2) - a(2)*force(1) + b(1)*force(first + 2) - b(2)*force(first + 1)
            end associate
            if (load%rates(1) > 2) moment = moment + force(3)
            if (load%rates(2) > 2) moment = moment + force(first + 3)
            call check(maxval(abs(total)) <= 1.0e-14_wp*maxval(abs(force)), 'no force in all')
            call check_close(moment, 0.0_wp, 1.0e-13_wp*maxval(abs(force)), 'no moment in all')
            deallocate (force)
         end associate
      end do
   end subroutine test_reaction

   !> Where the points of a spring meet: one of free length zero pulls with stiffness times distance in every direction; others,
   !> and dampers, stay finite.
   subroutine test_meeting()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp) :: q(2), w(2), force(2), stiffness(2, 2), damping(2, 2), energy, distance
      integer :: bead, peg, i, k
      model = empty_model(1.0_wp)
      bead = add_place(model, 'bead', add_point_mass(model, 'bead', 1.0_wp, [0.0_wp, 0.0_wp]), [0.0_wp, 0.0_wp])
      peg = add_place(model, 'peg', ground, [0.0_wp, 0.0_wp])
      call add_spring(model, bead, peg, 8.0_wp, 0.0_wp, 0.0_wp)
      call add_spring(model, peg, bead, 8.0_wp, 0.25_wp, 2.0_wp)
      system = new_system(model)
      call new_workspace(system, work)
      w = [0.3_wp, -0.4_wp]
      distance = 0.0_wp
      do k = -20, 0
         do i = 1, 2
            q = distance*[0.8_wp, 0.6_wp]
            call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
            force = 0.0_wp
            stiffness = 0.0_wp
            damping = 0.0_wp
            energy = 0.0_wp
            call system%loads(i)%item%add_force(work%kinematics, force)
            call system%loads(i)%item%add_tangent(work%kinematics, stiffness, damping)
            call system%loads(i)%item%add_energy(work%kinematics, energy)
            call check(norm2(force) <= 8.0_wp*max(distance, 0.25_wp) + 1.0_wp, 'a force that is finite')
            call check(maxval(abs(stiffness)) <= 1.0e12_wp .and. maxval(abs(damping)) <= 2.0_wp, 'derivatives that are finite')
            if (i == 2) cycle
            call check(maxval(abs(force + 8.0_wp*q)) <= 1.0e-15_wp*distance, 'pull of a spring without length')
            call check(maxval(abs(stiffness - reshape([8.0_wp, 0.0_wp, 0.0_wp, 8.0_wp], [2, 2]))) <= 0.0_wp, 'its stiffness')
            call check_close(energy, 4.0_wp*distance**2, 1.0e-15_wp*distance**2 + 1.0e-19_wp, 'its energy')
         end do
         distance = 10.0_wp**k
      end do
      ! At 1/10 of the length: shorter by 0.15, points parting at 0
      call check_close(distance, 1.0_wp, 0.0_wp, 'the last distance')
      q = 0.1_wp*[0.8_wp, 0.6_wp]
      call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
      force = 0.0_wp
      call system%loads(2)%item%add_force(work%kinematics, force)
      call check(maxval(abs(force - 8.0_wp*0.15_wp*[0.8_wp, 0.6_wp])) <= 1.0e-14_wp, 'a compressed spring pushes')
   end subroutine test_meeting

   !> A damper pulls against the speed at which its points part, and takes that power.
   subroutine test_constant_pull()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp) :: q(2), w(2), force(2), power
      integer :: bead, peg
      model = empty_model(1.0_wp)
      bead = add_place(model, 'bead', add_point_mass(model, 'bead', 1.0_wp, [0.0_wp, 0.0_wp]), [0.0_wp, 0.0_wp])
      peg = add_place(model, 'peg', ground, [0.0_wp, 0.0_wp])
      call add_spring(model, peg, bead, 0.0_wp, 0.0_wp, 2.0_wp)
      system = new_system(model)
      call new_workspace(system, work)
      q = [0.5_wp, 0.0_wp]
      w = [3.0_wp, 7.0_wp]
      call place(system, work, q, w, 1, 0.0_wp, 0.0_wp)
      force = 0.0_wp
      power = 0.0_wp
      call system%loads(1)%item%add_force(work%kinematics, force)
      call system%loads(1)%item%add_power(work%kinematics, power)
      call check(maxval(abs(force - [-6.0_wp, 0.0_wp])) <= 1.0e-14_wp, 'pull of a damper')
      call check_close(power, -18.0_wp, 1.0e-13_wp, 'power that it takes')
   end subroutine test_constant_pull

end program test_loads
