!> What static and modal analyses are made of: the tangent of a scene in steady rotation against differences, the motions that
!> constraints leave, motion that constraints determine, and eigenvalues of random matrices.
program test_equilibrium
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_model_model, only: model_type, ground
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_equations_of_motion, only: linearise, accelerations
   use limber_multibody_dense_eigenmodes, only: quadratic_modes, symmetric_modes
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium, linearise_balance
   use limber_multibody_free_motions, only: free_motions_type, find_freedom, lowest_stiffness
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, held_position, held_motion
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_layout, only: advance
   use limber_multibody_sparse_eigenmodes, only: nearest_eigenvalues, by_mass, by_scales
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent_products, only: times_stiffness
   use limber_multibody_small_vibrations, only: find_large_vibrations, find_vibrations, no_damping, vibrations_type
   use scenes, only: joint_revolute, add_beam, add_driver, constant_law, derivative, empty_model, join, random, slider_crank
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: t = 0.37_wp, step = 1.0e-3_wp

   call test_rotation(fidelity_kg)
   call test_rotation(fidelity_linear)
   call test_freedom()
   call test_held()
   call test_eigenvalues()
   call test_spectrum([0.0_wp, 269.0_wp, 819.0_wp, 1449.0_wp, 1.0e5_wp], 0)
   call test_spectrum([0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 3.0_wp, 1.0e3_wp, 1.0e5_wp], 0)
   call test_spectrum([0.0_wp, 0.0_wp, 2.0_wp, 5.0_wp, 700.0_wp], 2)
   call test_spectrum([-3.0_wp, 0.0_wp, 2.0_wp, 5.0_wp, 1.0e4_wp], 1)
   call test_spectrum([1.0e-2_wp, 5.0_wp, 1.0e3_wp], 3)
   call test_spectrum([0.0_wp, 0.0_wp], 0)
   call test_large()
   call test_large_vibrations(.true.)
   call test_large_vibrations(.false.)
   call finish()

contains

   subroutine build(fidelity, system, work)
      integer, intent(in) :: fidelity
      type(system_type), intent(out) :: system
      type(workspace_type), intent(inout) :: work
      type(model_type) :: model
      type(error_type), allocatable :: error
      call slider_crank(fidelity, 5.0e2_wp, model, error)
      call check_no_error(error, 'slider-crank')
      system = new_system(model)
      call new_workspace(system, work)
   end subroutine build

   !> Derivatives of the residual of a scene that turns as a whole, at a random place.
   subroutine test_rotation(fidelity)
      integer, intent(in) :: fidelity
      type(system_type) :: system
      type(workspace_type) :: work
      type(equilibrium_type) :: balance
      real(wp), allocatable :: q(:), moved(:), v(:), lambda(:), change(:), residual(:, :), column(:), unit(:)
      real(wp) :: worst, largest
      integer :: i, k
      integer, parameter :: shift(4) = [-2, -1, 1, 2]
      call build(fidelity, system, work)
      call new_equilibrium(system, balance)
      balance%rotation = 1.7_wp
      balance%centre = [0.3_wp, -0.2_wp]
      associate (nq => system%layout%nq, nw => system%layout%nw)
         allocate (q(nq), moved(nq), v(nq), lambda(system%nc), change(nw), residual(nw, 4), column(nw), unit(nw))
         call first_guess(system, t, q, v)
         do i = 1, size(lambda)
            lambda(i) = random()
         end do
         do i = 1, nw
            change(i) = 0.1_wp*random()
         end do
         call advance(system%layout, q, change, moved)
         q = moved
         worst = 0.0_wp
         largest = 0.0_wp
         do i = 1, nw
            do k = 1, 4
               change = 0.0_wp
               change(i) = shift(k)*step
               call advance(system%layout, q, change, moved)
               call linearise_balance(system, work, balance, t, moved, lambda)
               residual(:, k) = balance%motion
            end do
            call linearise_balance(system, work, balance, t, q, lambda)
            unit = 0.0_wp
            unit(i) = 1.0_wp
            column = 0.0_wp
            call times_stiffness(system, balance%tangent, 1.0_wp, unit, column)
            worst = max(worst, maxval(abs(column - derivative(residual(:, 1), residual(:, 2), residual(:, 3), residual(:, 4), &
               & step))))
            largest = max(largest, maxval(abs(column)))
         end do
      end associate
      call check_close(worst/largest, 0.0_wp, 1.0e-11_wp, 'derivatives in steady rotation')
   end subroutine test_rotation

   !> The basis is tangent to every constraint, and with the driver away one motion of the frames is left.
   subroutine test_freedom()
      type(system_type) :: system
      type(workspace_type) :: work
      type(free_motions_type) :: freedom
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), moved(:), before(:)
      real(wp), parameter :: h = 1.0e-5_wp
      integer :: culprit, j, i
      call build(fidelity_linear, system, work)
      allocate (q(system%layout%nq), v(system%layout%nq), moved(system%layout%nq), before(system%nc))
      call first_guess(system, t, q, v)
      call assemble(system, work, t, q, v, error, culprit)
      call check_no_error(error, 'assembly')
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call update_jacobians(system, work)
      call find_freedom(system, work, .false., freedom)
      call check(freedom%rank == system%nc, 'the constraints are independent')
      call check(size(freedom%basis, 2) == system%layout%nw - system%nc, 'motions that are left')
      do j = 1, size(freedom%basis, 2)
         do i = -1, 1, 2
            call advance(system%layout, q, i*h*freedom%basis(:, j), moved)
            call place_frames(system%model, system%layout, t, moved, work%kinematics)
            call residuals(system, work)
            if (i < 0) before = work%phi
         end do
         call check_close(maxval(abs(work%phi - before))/(2*h), 0.0_wp, 1.0e-8_wp, 'a free motion breaks no constraint')
      end do
   end subroutine test_freedom

   subroutine residuals(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            call item%residual(work%kinematics, work%phi(item%first:item%first + item%rows - 1))
         end associate
      end do
   end subroutine residuals

   !> Of a rigid scene that is driven wholly: the same accelerations and multipliers as the equations of motion give.
   subroutine test_held()
      type(system_type) :: system
      type(workspace_type) :: work
      type(driven_motion_type) :: held
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), a(:), lambda(:), other(:)
      real(wp) :: change
      integer :: culprit
      logical :: done
      call build(0, system, work)
      allocate (q(system%layout%nq), v(system%layout%nq), a(system%layout%nq), other(system%layout%nq))
      call first_guess(system, t, q, v)
      call assemble(system, work, t, q, v, error, culprit)
      call check_no_error(error, 'assembly')
      call new_held(system, held)
      call held_position(system, work, held, t + 0.01_wp, q, change, done)
      call check(done .and. change > 1.0e-3_wp, 'a position a little later')
      call held_motion(system, work, held, t + 0.01_wp, q, v, a, done)
      call check(done, 'its motion')
      allocate (lambda, source=work%lambda)
      call linearise(system, work, t + 0.01_wp, q, error)
      call accelerations(system, work, q, v, other)
      call check_close(maxval(abs(a - other)), 0.0_wp, 1.0e-11_wp*maxval(abs(a)), 'accelerations')
      call check_close(maxval(abs(lambda - work%lambda)), 0.0_wp, 1.0e-11_wp*maxval(abs(lambda)), 'multipliers')
   end subroutine test_held

   !> Residuals of the eigenvalue problems; a singular mass, a singular stiffness; both ways agree.
   subroutine test_eigenvalues()
      integer, parameter :: n = 6
      real(wp) :: mass(n, n), damping(n, n), stiffness(n, n), shape(n, n)
      complex(wp), allocatable :: value(:), vector(:, :), same(:), other(:, :)
      integer :: i, j
      do j = 1, n
         do i = 1, n
            shape(i, j) = random()
         end do
      end do
      stiffness = matmul(transpose(shape), shape)
      mass = 0.0_wp
      do i = 1, n - 1
         mass(i, i) = 1.0_wp + 0.1_wp*i
      end do
      damping = 0.0_wp
      call symmetric_modes(mass, stiffness, n, value, vector)
      call quadratic_modes(mass, damping, stiffness, n, same, other)
      call check(size(value) == n - 1 .and. size(same) == n - 1, 'a coordinate without mass has no mode')
      if (size(value) == size(same)) call check_close(maxval(abs(value - same)/abs(value)), 0.0_wp, 1.0e-10_wp, &
         & 'symmetric and general eigenvalues')
      call check_residual(mass, damping, stiffness, value, vector, 'symmetric')
      damping = 0.2_wp*shape
      mass(n, n) = 1.5_wp
      call quadratic_modes(mass, damping, stiffness, n, value, vector)
      call check_residual(mass, damping, stiffness, value, vector, 'damped')
      ! A free coordinate
      stiffness(:, n) = 0.0_wp
      stiffness(n, :) = 0.0_wp
      call symmetric_modes(mass, stiffness, n, value, vector)
      call check(size(value) == n, 'a free coordinate has a mode')
      call check_close(abs(value(1)), 0.0_wp, 1.0e-6_wp, 'of no frequency')
   end subroutine test_eigenvalues

   !> Spectra that are known, K = M X diag(omega^2) X^T M with X^T M X = 1: free motions, motions without mass, and growth, beside
   !> frequencies over eight decades. As many come out as go in.
   subroutine test_spectrum(frequency, light)
      !> Circular frequencies; negative: rates of growth
      real(wp), intent(in) :: frequency(:)
      !> Motions without mass
      integer, intent(in) :: light
      real(wp), allocatable :: shape(:, :), mass(:, :), stiffness(:, :), weighted(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      real(wp) :: wanted, zero
      integer :: n, i, j, k, way
      ! The round-off of the largest
      zero = 1.0e-12_wp*maxval(frequency)**2
      n = size(frequency) + light
      allocate (shape(n, n), mass(n, n), stiffness(n, n), weighted(n, n))
      do j = 1, n
         do i = 1, n
            shape(i, j) = random() + merge(2.0_wp, 0.0_wp, i == j)
         end do
      end do
      ! In coordinates y = shape x, of masses 0.01, 0.1, 1
      mass = 0.0_wp
      stiffness = 0.0_wp
      do j = 1, n
         weighted(:, j) = [(shape(i, j)*merge(10.0_wp**(-modulo(i, 3)), 0.0_wp, i > light), i=1, n)]
      end do
      mass = matmul(transpose(shape), weighted)
      do j = 1, n
         weighted(:, j) = 1.0e4_wp*shape(:, j)
         do i = light + 1, n
            k = i - light
            weighted(i, j) = shape(i, j)*10.0_wp**(-modulo(i, 3))*frequency(k)*abs(frequency(k))
         end do
      end do
      stiffness = matmul(transpose(shape), weighted)
      do way = 1, 2
         if (way == 1) call symmetric_modes(mass, stiffness, n, value, vector)
         if (way == 2) call quadratic_modes(mass, 0*mass, stiffness, 2*n, value, vector)
         call check(allocated(value), 'a spectrum is found')
         if (.not. allocated(value)) return
         call check(size(value) == size(frequency) .or. way == 2, 'as many modes as motions with mass')
         do k = 1, size(frequency)
            wanted = abs(frequency(k))
            call check(any(abs(abs(value)**2 - wanted**2) <= 1.0e-7_wp*wanted**2 + zero), 'a mode of a known spectrum')
         end do
         ! Round-off may part s = 0 into a pair
         call check(count(abs(value)**2 <= zero) == count(abs(frequency) <= 0.0_wp) .or. way == 2 .and. count(abs(value)**2 &
            & <= zero) >= count(abs(frequency) <= 0.0_wp), 'as many free motions as there are')
      end do
   end subroutine test_spectrum

   !> A beam with many modes, clamped or hinged at its start.
   function cantilever(clamped) result(model)
      logical, intent(in) :: clamped
      type(model_type) :: model
      type(error_type), allocatable :: error
      integer :: beam
      model = empty_model(2.0_wp)
      beam = add_beam(model, 'beam', beam_type(ea=1.0e4_wp, ei=3.0_wp, rho_a=0.7_wp, length=2.0_wp, elements=30), &
         & reduction_type(support=new_support('CLAMPED-FREE'), bending=25, axial=2, fidelity=fidelity_kg), [0.0_wp, 0.0_wp], &
         & 0.0_wp, error)
      call check_no_error(error, 'cantilever')
      call join(model, 'wall', joint_revolute, beam, [0.0_wp, 0.0_wp], ground, [0.0_wp, 0.0_wp])
      if (clamped) call add_driver(model, 'clamp', beam, constant_law(0.0_wp))
   end function cantilever

   !> The modes of large scenes are those of small ones: of a cantilever, and of a beam that is free to turn.
   subroutine test_large_vibrations(clamped)
      logical, intent(in) :: clamped
      integer, parameter :: wanted = 5
      type(system_type) :: system
      type(workspace_type) :: work
      type(equilibrium_type) :: balance
      type(vibrations_type) :: large, small
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), lambda(:)
      real(wp) :: scale
      integer :: j
      system = new_system(cantilever(clamped))
      call new_workspace(system, work)
      call new_equilibrium(system, balance)
      allocate (q(system%layout%nq), v(system%layout%nq), lambda(system%nc))
      call first_guess(system, t, q, v)
      lambda = 0.0_wp
      call linearise_balance(system, work, balance, t, q, lambda)
      call find_freedom(system, work, .false., balance%freedom)
      call find_vibrations(system, balance%tangent, balance%freedom, no_damping, wanted, small, error)
      call check_no_error(error, 'modes of a small scene')
      call find_large_vibrations(system, balance%tangent, wanted, large, error)
      call check_no_error(error, 'modes of a large scene')
      call check(size(large%frequency) == wanted .and. size(small%frequency) == wanted, 'as many modes as were wanted')
      scale = small%frequency(2)
      if (.not. clamped) call check_close(small%frequency(1), 0.0_wp, 1.0e-6_wp*scale, 'it turns freely')
      do j = 1, wanted
         ! Round-off of the square, of what moves freely too
         call check_close(large%frequency(j), small%frequency(j), 1.0e-5_wp*scale, 'frequency of a large scene')
         if (clamped .or. j > 1) call check_close(large%frequency(j)/small%frequency(j), 1.0_wp, 1.0e-9_wp, &
            & 'frequency of a large scene')
         call check_close(large%growth(j), 0.0_wp, 1.0e-5_wp*scale, 'nothing grows')
         call check_close(maxval(abs(large%shape(:, j) - small%shape(:, j)))/maxval(abs(small%shape(:, j))), 0.0_wp, 1.0e-6_wp, &
            & 'shape of a large scene')
      end do
   end subroutine test_large_vibrations

   !> The way of large scenes, on a cantilever: its own frequencies, and the same lowest stiffness as from dense matrices.
   subroutine test_large()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(equilibrium_type) :: balance
      real(wp), allocatable :: q(:), v(:), lambda(:), motion(:, :), softest(:)
      real(wp) :: value(4), lowest, largest
      integer, parameter :: beam = 1
      integer :: i
      logical :: done
      model = cantilever(.true.)
      system = new_system(model)
      call new_workspace(system, work)
      call new_equilibrium(system, balance)
      allocate (q(system%layout%nq), v(system%layout%nq), lambda(system%nc), motion(system%layout%nw, 4))
      allocate (softest(system%layout%nw))
      call first_guess(system, t, q, v)
      lambda = 0.0_wp
      call linearise_balance(system, work, balance, t, q, lambda)
      call nearest_eigenvalues(system, balance%tangent, by_mass, 0.0_wp, 4, value, motion, done)
      call check(done, 'eigenvalues of a sparse scene')
      do i = 1, 4
         call check_close(value(i)/minval(model%bodies(beam)%reduced%omega2, mask=model%bodies(beam)%reduced%omega2 > &
            & 0.99_wp*value(i)), 1.0_wp, 1.0e-9_wp, 'frequency of a cantilever')
      end do
      call find_freedom(system, work, .false., balance%freedom)
      call lowest_stiffness(system, balance%tangent, balance%freedom, lowest, largest, softest)
      call nearest_eigenvalues(system, balance%tangent, by_scales, 0.0_wp, 4, value, motion, done)
      call check(done, 'stiffness of a sparse scene')
      call check_close(value(1)/lowest, 1.0_wp, 1.0e-9_wp, 'lowest stiffness')
   end subroutine test_large

   subroutine check_residual(mass, damping, stiffness, value, vector, title)
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      complex(wp), intent(in) :: value(:), vector(:, :)
      character(*), intent(in) :: title
      complex(wp) :: left(size(vector, 1))
      integer :: j
      do j = 1, size(value)
         left = matmul(value(j)**2*mass + value(j)*damping + stiffness, vector(:, j))
         call check_close(maxval(abs(left))/maxval(abs(vector(:, j)))/maxval(abs(stiffness)), 0.0_wp, 1.0e-11_wp, &
            & title//' eigenvalues satisfy their equation')
         call check(aimag(value(j)) >= 0.0_wp, title//': of a pair the one of positive frequency')
      end do
   end subroutine check_residual

end program test_equilibrium
