!> The Radau integrator: its coefficients against the conditions that define them, order at fixed steps, errors that follow the
!> tolerance, constraints in every step, values between the steps, energy and the work put in, stiffness; and the same motions as
!> the Adams integrator, which shares nothing with it but the equations.
program test_radau
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_integrator_adams, only: adams_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_radau, only: radau_type
   use limber_integrator_radau_method, only: radau_a, radau_c, radau_lambda, radau_t, radau_ti
   use limber_model_model, only: driver_type, ground, model_type
   use limber_multibody_assembly, only: first_guess
   use limber_multibody_equations_of_motion, only: mechanical_energy, position_residual, velocity_residual
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, add_beam, add_rigid, empty_model, join, slider_crank
   use swings, only: begin, g, pendulum, place, swing_of
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]
   !> Axial rigidity of a rod whose axial vibration matters
   real(wp), parameter :: soft = 5.0e4_wp

   !> A run: state at its end, work put in, and what went by
   type :: run_type
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: w = 0.0_wp
      !> Largest work put in, largest energy gained and lost beyond it, at steps
      real(wp) :: most = 0.0_wp, gain = 0.0_wp, loss = 0.0_wp
      !> Largest residuals of position and velocity constraints, |u| - 1, u'.u, at steps
      real(wp) :: residual(4) = 0.0_wp
      !> Largest difference of coordinates within steps with and without their velocities
      real(wp) :: apart = 0.0_wp
      integer :: steps = 0, rejected = 0
   end type run_type

   call test_coefficients()
   call test_order_of_pendulum()
   call test_order_of_crank()
   call test_order_of_work()
   call test_tolerance_of_pendulum()
   call test_tolerance_of_crank()
   call test_between()
   call test_fall()
   call test_work(fidelity_linear)
   call test_work(fidelity_kg)
   call test_ringing()
   call test_flight()
   call test_stiff()
   call test_agreement()
   call test_limits_of_step()
   call test_repeatable()
   call test_singular()
   call finish()

contains

   !> Radau IIA: quadrature of degree 4, stages of order 3, the last stage is the end; and the transformation is one.
   subroutine test_coefficients()
      real(wp) :: inverse(3, 3), identity(3, 3)
      integer :: k
      identity = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      inverse = matmul(radau_t, matmul(radau_lambda, radau_ti))
      call check(maxval(abs(matmul(inverse, radau_a) - identity)) <= 1.0e-14_wp, 'T Lambda T^-1 A = 1')
      call check(maxval(abs(matmul(radau_a, inverse) - identity)) <= 1.0e-14_wp, 'A T Lambda T^-1 = 1')
      call check(maxval(abs(matmul(radau_t, radau_ti) - identity)) <= 1.0e-14_wp, 'T T^-1 = 1')
      do k = 0, 4
         call check_close(sum(radau_a(3, :)*radau_c**k), 1.0_wp/(k + 1), 1.0e-15_wp, 'weights, degree '//as_text(k))
      end do
      do k = 1, 3
         call check(maxval(abs(matmul(radau_a, radau_c**(k - 1)) - radau_c**k/k)) <= 1.0e-15_wp, 'stages, order '//as_text(k))
      end do
      call check(abs(radau_c(3) - 1) <= 0.0_wp, 'stiffly accurate')
      ! The nodes are the zeros of d^2/dx^2 of x^2 (x - 1)^3 but for a factor: 10 x^3 - 18 x^2 + 9 x - 1
      call check(maxval(abs(((10*radau_c - 18)*radau_c + 9)*radau_c - 1)) <= 1.0e-14_wp, 'nodes of Radau')
   end subroutine test_coefficients

   !> The shared slider-crank; without its motor, if so wanted.
   function crank_with(fidelity, ea, is_driven) result(model)
      integer, intent(in) :: fidelity
      real(wp), intent(in) :: ea
      logical, intent(in) :: is_driven
      type(model_type) :: model
      type(error_type), allocatable :: error
      type(driver_type), allocatable :: none(:)
      call slider_crank(fidelity, ea, model, error)
      call check_no_error(error, 'slider-crank')
      allocate (none(0))
      if (.not. is_driven) call move_alloc(none, model%drivers)
   end function crank_with

   !> Runs a model and looks at every step; the steps may be given.
   subroutine run(model, integrator, tolerance, duration, outcome, h)
      type(model_type), intent(in) :: model
      class(integrator_type), intent(inout) :: integrator
      real(wp), intent(in) :: tolerance, duration
      type(run_type), intent(out) :: outcome
      real(wp), intent(in), optional :: h
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), place(:)
      real(wp) :: kinetic, potential, start, excess, stop
      integer :: i
      call begin(model, tolerance, duration, system, work, integrator, q, v)
      place = q
      call mechanical_energy(system, work, q, v, kinetic, potential)
      start = kinetic + potential
      stop = duration
      do while (integrator%t < duration)
         if (present(h)) then
            stop = min(duration, h*(integrator%statistics%steps + 1))
            select type (integrator)
            type is (radau_type)
               integrator%h = h
            end select
         end if
         call integrator%step(system, work, stop, error)
         call check_no_error(error, 'step')
         if (allocated(error)) exit
         stop = 0.7_wp*integrator%t + 0.3_wp*integrator%t_before
         call integrator%interpolate(stop, q, v, outcome%w)
         call integrator%interpolate_place(stop, place, v, outcome%w)
         outcome%apart = max(outcome%apart, maxval(abs(place - q)))
         stop = duration
         call integrator%interpolate(integrator%t, q, v, outcome%w)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         excess = kinetic + potential - start - outcome%w
         outcome%gain = max(outcome%gain, excess)
         outcome%loss = max(outcome%loss, -excess)
         outcome%most = max(outcome%most, abs(outcome%w))
         call place_frames(system%model, system%layout, integrator%t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         call update_jacobians(system, work)
         outcome%residual(:2) = max(outcome%residual(:2), [position_residual(system, work), velocity_residual(system, work, v)])
         do i = 1, size(system%layout%q)
            if (.not. system%layout%framed(i)) cycle
            associate (u => q(system%layout%q(i) + 2:system%layout%q(i) + 3), &
               & rate => v(system%layout%q(i) + 2:system%layout%q(i) + 3))
               outcome%residual(3:) = max(outcome%residual(3:), [abs(norm2(u) - 1), abs(dot_product(u, rate))])
            end associate
         end do
      end do
      allocate (outcome%q, source=q)
      allocate (outcome%v, source=v)
      outcome%steps = int(integrator%statistics%steps)
      outcome%rejected = int(integrator%statistics%rejected)
   end subroutine run

   !> A run at steps of one length. The tolerance is a multiple of h^4, just above the error estimate, which is of that order, so
   !> that no step is rejected; the Newton iteration is then broken off at a part of h^6, which does not disturb order five.
   subroutine run_fixed(model, steps, multiple, duration, outcome)
      type(model_type), intent(in) :: model
      integer, intent(in) :: steps
      real(wp), intent(in) :: multiple, duration
      type(run_type), intent(out) :: outcome
      type(radau_type) :: integrator
      real(wp) :: h
      h = duration/steps
      call run(model, integrator, (10*multiple*h**4)**1.25_wp, duration, outcome, h)
      call check(outcome%rejected == 0 .and. outcome%steps == steps, 'steps of one length: '//as_text(outcome%rejected)// &
         & ' rejected, '//as_text(outcome%steps)//' of '//as_text(steps))
   end subroutine run_fixed

   !> The same by Adams, as well as it can.
   subroutine run_reference(model, duration, outcome)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: duration
      type(run_type), intent(out) :: outcome
      type(adams_type) :: integrator
      call run(model, integrator, 1.0e-12_wp, duration, outcome)
   end subroutine run_reference

   !> Order from errors at steps halved again and again, by least squares: from one to the next the Newton iteration adds a little
   !> or does not.
   subroutine check_order(error, least, most, name)
      real(wp), intent(in) :: error(:), least, most
      character(*), intent(in) :: name
      real(wp) :: order
      integer :: i
      order = slope([(0.5_wp**i, i=1, size(error))], error)
      call check(order >= least .and. order <= most, name//': order '//as_text(order, 4))
   end subroutine check_order

   !> Slope of log error over log of tolerance or step, by least squares.
   pure real(wp) function slope(tolerance, error)
      real(wp), intent(in) :: tolerance(:), error(:)
      real(wp) :: x(size(error)), y(size(error))
      x = log(tolerance)
      y = log(error)
      x = x - sum(x)/size(x)
      slope = sum(x*(y - sum(y)/size(y)))/sum(x**2)
   end function slope

   subroutine test_order_of_pendulum()
      type(run_type) :: outcome
      real(wp) :: error(4)
      integer :: i
      do i = 1, 4
         call run_fixed(pendulum(), 160*2**i, 200.0_wp, 10.0_wp, outcome)
         error(i) = norm2(outcome%q(3:4) - place)
         call check_residuals(outcome, 'pendulum')
      end do
      call check_order(error, 4.6_wp, 5.5_wp, 'pendulum')
   end subroutine test_order_of_pendulum

   !> Where joints close a loop: the mechanism let go, and driven with a rod that bends and rings.
   subroutine test_order_of_crank()
      real(wp), parameter :: duration = 0.2_wp, driven = 0.15_wp
      type(run_type) :: outcome, reference
      real(wp) :: error(3), speed(3)
      integer :: i
      call run_reference(crank_with(0, soft, .false.), duration, reference)
      call check(norm2(reference%v) > 1.0_wp, 'the slider-crank falls')
      do i = 1, 3
         call run_fixed(crank_with(0, soft, .false.), 5*2**i, 1.0e3_wp, duration, outcome)
         error(i) = maxval(abs(outcome%q - reference%q))
         speed(i) = maxval(abs(outcome%v - reference%v))
         call check_residuals(outcome, 'rigid slider-crank')
      end do
      call check_order(error, 4.6_wp, 5.5_wp, 'rigid slider-crank')
      call check_order(speed, 4.6_wp, 5.5_wp, 'its speeds')
      call run_reference(crank_with(fidelity_kg, soft, .true.), driven, reference)
      do i = 1, 3
         call run_fixed(crank_with(fidelity_kg, soft, .true.), 160*2**i, 1.0e10_wp, driven, outcome)
         error(i) = maxval(abs(outcome%q - reference%q))
         call check_residuals(outcome, 'flexible slider-crank')
      end do
      call check_order(error, 4.6_wp, 5.5_wp, 'flexible slider-crank')
   end subroutine test_order_of_crank

   !> A rigid driven mechanism moves as it must whatever the step; only the work that it takes has an error.
   subroutine test_order_of_work()
      real(wp), parameter :: duration = 0.15_wp
      type(run_type) :: outcome, reference
      real(wp) :: error(4)
      integer :: i
      call run_reference(crank_with(0, soft, .true.), duration, reference)
      call check(reference%most > 1.0_wp, 'there is work')
      do i = 1, 4
         call run_fixed(crank_with(0, soft, .true.), 10*2**i, 1.0e5_wp, duration, outcome)
         call check(maxval(abs(outcome%q - reference%q)) <= 1.0e-13_wp, 'a driven mechanism moves as it must')
         error(i) = max(outcome%gain, outcome%loss)
      end do
      call check_order(error, 3.6_wp, 6.0_wp, 'work of a driven mechanism')
   end subroutine test_order_of_work

   !> Constraints at round-off in every step. They are met to 1e-14; the values asked for come from the increment of the step, which
   !> costs another rounding.
   subroutine check_residuals(outcome, name)
      type(run_type), intent(in) :: outcome
      character(*), intent(in) :: name
      call check_close(outcome%apart, 0.0_wp, 1.0e-15_wp, name//': places alone')
      call check_close(outcome%residual(1), 0.0_wp, 1.1e-14_wp, name//': position constraints')
      call check_close(outcome%residual(2), 0.0_wp, 1.0e-13_wp, name//': velocity constraints')
      call check_close(outcome%residual(3), 0.0_wp, 3.4e-16_wp, name//': u of unit length')
      call check_close(outcome%residual(4), 0.0_wp, 2.0e-14_wp, name//': u'' square to u')
   end subroutine check_residuals

   subroutine test_tolerance_of_pendulum()
      real(wp), parameter :: tolerance(4) = [1.0e-4_wp, 1.0e-6_wp, 1.0e-8_wp, 1.0e-10_wp]
      type(radau_type), allocatable :: integrator
      type(run_type) :: outcome
      real(wp) :: error(4)
      integer :: i, steps(4)
      do i = 1, 4
         allocate (integrator)
         call run(pendulum(), integrator, tolerance(i), 10.0_wp, outcome)
         deallocate (integrator)
         error(i) = norm2(outcome%q(3:4) - place)
         steps(i) = outcome%steps
         call check_residuals(outcome, 'pendulum')
         call check(abs(outcome%w) <= 0.0_wp, 'no work is put in')
         call check(outcome%rejected < 0.2_wp*outcome%steps, 'few steps are rejected')
      end do
      call check(slope(tolerance, error) > 0.6_wp .and. slope(tolerance, error) < 1.4_wp, &
         & 'pendulum: slope '//as_text(slope(tolerance, error), 3))
      call check(all(error(2:) < 0.2_wp*error(:3)), 'the error falls with the tolerance')
      call check(all(error <= 10*tolerance), 'the error is not far from the tolerance')
      call check(steps(1) < 200 .and. steps(4) < 5000, 'not too many steps')
   end subroutine test_tolerance_of_pendulum

   !> Deflections of the rod, its modal coordinates.
   subroutine test_tolerance_of_crank()
      real(wp), parameter :: tolerance(4) = [1.0e-4_wp, 1.0e-6_wp, 1.0e-8_wp, 1.0e-10_wp], duration = 0.15_wp
      type(radau_type), allocatable :: integrator
      type(run_type) :: outcome, reference
      real(wp) :: error(4)
      integer :: i
      call run_reference(crank_with(fidelity_kg, soft, .true.), duration, reference)
      do i = 1, 4
         allocate (integrator)
         call run(crank_with(fidelity_kg, soft, .true.), integrator, tolerance(i), duration, outcome)
         deallocate (integrator)
         ! The rod's eta follow [r, u] of crank and rod
         error(i) = maxval(abs(outcome%q(9:12) - reference%q(9:12)))
         call check_residuals(outcome, 'flexible slider-crank')
      end do
      call check(slope(tolerance, error) > 0.6_wp .and. slope(tolerance, error) < 1.4_wp, &
         & 'flexible slider-crank: slope '//as_text(slope(tolerance, error), 3))
      call check(all(error(2:) < 0.2_wp*error(:3)), 'deflections: the error falls with the tolerance')
   end subroutine test_tolerance_of_crank

   !> Between steps of one length, at nine places of each, the error is of the same order, and hardly larger.
   subroutine test_between()
      type(radau_type), allocatable :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: w, t, last, theta, omega, h, at_steps(2, 3), between(2, 3), found(2)
      integer :: run, i
      at_steps = 0.0_wp
      between = 0.0_wp
      do run = 1, 3
         allocate (integrator)
         h = 0.0625_wp/2**run
         integrator%initial_step = h
         integrator%maximum_step = h
         call begin(pendulum(), 200*h**4, 3.0_wp, system, work, integrator, q, v)
         last = 0.0_wp
         theta = 0.0_wp
         omega = 0.0_wp
         do while (integrator%t < 3.0_wp)
            call integrator%step(system, work, 3.0_wp, error)
            call check_no_error(error, 'step')
            if (allocated(error)) return
            do i = 1, 10
               t = integrator%t_before + (integrator%t - integrator%t_before)*0.1_wp*i
               if (i == 10) t = integrator%t
               call swing_of(last, t, theta, omega)
               last = t
               call integrator%interpolate(t, q, v, w)
               found(1) = norm2(q(3:4) - [cos(theta), sin(theta)])
               found(2) = norm2(v(3:4) - omega*[-sin(theta), cos(theta)])
               if (i == 10) then
                  at_steps(:, run) = max(at_steps(:, run), found)
               else
                  between(:, run) = max(between(:, run), found)
               end if
            end do
         end do
         deallocate (integrator)
      end do
      call check_order(between(1, :), 4.5_wp, 6.0_wp, 'coordinates between the steps')
      call check_order(between(2, :), 4.5_wp, 6.0_wp, 'velocities between the steps')
      call check(all(between <= 2*at_steps), 'no worse than at the steps')
   end subroutine test_between

   !> The slider-crank let go is smooth: hardly a step is rejected, and the Newton iteration does not give up while it converges.
   subroutine test_fall()
      type(radau_type) :: integrator
      type(run_type) :: outcome, reference
      call run_reference(crank_with(0, soft, .false.), 0.8_wp, reference)
      call run(crank_with(0, soft, .false.), integrator, 1.0e-5_wp, 0.8_wp, outcome)
      call check(outcome%steps < 150 .and. outcome%rejected < 15, 'falling slider-crank: '//as_text(outcome%steps)// &
         & ' steps, '//as_text(outcome%rejected)//' rejected')
      call check_close(maxval(abs(outcome%q - reference%q)), 0.0_wp, 1.0e-4_wp, 'falling slider-crank: place')
      call check_close(max(outcome%gain, outcome%loss), 0.0_wp, 1.0e-5_wp, 'falling slider-crank: energy')
   end subroutine test_fall

   !> What the motor and the force of the model k_g put in is what the mechanism has more, to the tolerance; and as Adams has it.
   subroutine test_work(fidelity)
      integer, intent(in) :: fidelity
      real(wp), parameter :: tolerance(4) = [1.0e-3_wp, 1.0e-5_wp, 1.0e-7_wp, 1.0e-9_wp], duration = 0.15_wp
      type(radau_type), allocatable :: integrator
      type(run_type) :: outcome, reference
      integer :: i
      call run_reference(crank_with(fidelity, soft, .true.), duration, reference)
      do i = 1, 4
         allocate (integrator)
         call run(crank_with(fidelity, soft, .true.), integrator, tolerance(i), duration, outcome)
         deallocate (integrator)
         call check_close(max(outcome%gain, outcome%loss), 0.0_wp, tolerance(i)*outcome%most, 'energy gained and work put in')
         ! The work of this moment depends on the phase of the ringing, whose error is many tolerances after 30 periods
         call check_close(outcome%w, reference%w, 100*tolerance(i)*reference%most, 'the work that Adams finds')
      end do
   end subroutine test_work

   !> A rod so stiff that its axial vibration is not resolved: the energy of that ringing is lost, as it should be with a method
   !> that damps, and none is ever gained.
   subroutine test_ringing()
      type(radau_type) :: integrator
      type(run_type) :: outcome
      call run(crank_with(fidelity_kg, 1.0e4_wp*soft, .true.), integrator, 1.0e-4_wp, 0.05_wp, outcome)
      call check(outcome%most > 0.1_wp, 'there is work to compare with')
      call check_close(outcome%loss, 0.0_wp, 1.0e-5_wp, 'ringing: energy that is lost')
      call check_close(outcome%gain, 0.0_wp, 0.1_wp*outcome%loss, 'ringing: energy that is gained')
      call check_residuals(outcome, 'ringing')
   end subroutine test_ringing

   !> A free beam that spins, flies and vibrates without weight: its energy stays, the better the tighter the tolerance.
   subroutine test_flight()
      real(wp), parameter :: tolerance(3) = [1.0e-5_wp, 1.0e-7_wp, 1.0e-9_wp], duration = 1.0_wp
      type(beam_type), parameter :: beam = beam_type(ea=4.0e3_wp, ei=1.0_wp, rho_a=1.0_wp, length=1.0_wp, elements=12)
      type(radau_type), allocatable :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: energy(2), kinetic, potential, w
      integer :: body, i
      model = empty_model(1.0_wp)
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=2, geometric_elements=6, &
         & fidelity=fidelity_linear, origin=0.2_wp)
      body = add_beam(model, 'beam', beam, choice, [0.3_wp, -0.4_wp], 0.5_wp, error)
      call check_no_error(error, 'beam')
      model%bodies(body)%velocity = [0.5_wp, 1.0_wp]
      model%bodies(body)%spin = 4.0_wp
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      do i = 1, 3
         allocate (integrator)
         call first_guess(system, 0.0_wp, q, v)
         q(5) = 0.03_wp
         v(6) = -0.4_wp
         integrator%tolerance = tolerance(i)
         call integrator%start(system, work, 0.0_wp, duration, q, v, error)
         call check_no_error(error, 'start')
         call mechanical_energy(system, work, q, v, kinetic, potential)
         energy(1) = kinetic + potential
         do while (integrator%t < duration)
            call integrator%step(system, work, duration, error)
            call check_no_error(error, 'step')
            if (allocated(error)) return
         end do
         call integrator%interpolate(duration, q, v, w)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         energy(2) = kinetic + potential
         call check_close(energy(2), energy(1), tolerance(i)*energy(1), 'energy of a free beam')
         deallocate (integrator)
      end do
   end subroutine test_flight

   !> A hanging beam swings once in seconds and vibrates 1e5 to 1e7 times a second: no more steps than for a rigid one, whose
   !> motion it has, and no vibration at the steps or between them.
   subroutine test_stiff()
      real(wp), parameter :: tolerance(3) = [1.0e-3_wp, 1.0e-4_wp, 1.0e-5_wp], duration = 5.0_wp
      type(beam_type), parameter :: beam = beam_type(ea=1.0e13_wp, ei=1.0e9_wp, rho_a=1.0_wp, length=1.0_wp, elements=8)
      type(radau_type), allocatable :: integrator
      type(adams_type) :: adams
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model, stiff
      type(reduction_type) :: choice
      type(run_type) :: reference
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: vibration, w
      integer :: body, i, j
      stiff = empty_model(1.0_wp)
      stiff%gravity = [0.0_wp, -g]
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=2, geometric_elements=4, &
         & fidelity=fidelity_linear)
      body = add_beam(stiff, 'beam', beam, choice, nil, 0.0_wp, error)
      call check_no_error(error, 'beam')
      call join(stiff, 'pin', joint_revolute, body, nil, ground, nil)
      associate (reduced => stiff%bodies(body)%reduced)
         call check(sqrt(maxval(reduced%omega2)) > 1.0e7_wp, 'axial vibration is fast')
         model = empty_model(1.0_wp)
         model%gravity = stiff%gravity
         body = add_rigid(model, 'beam', reduced%mass, reduced%i0 - dot_product(reduced%c0, reduced%c0)/reduced%mass, &
            & reduced%c0/reduced%mass, nil, 0.0_wp)
      end associate
      call join(model, 'pin', joint_revolute, body, nil, ground, nil)
      call run(model, adams, 1.0e-12_wp, duration, reference)
      do i = 1, 3
         allocate (integrator)
         call begin(stiff, tolerance(i), duration, system, work, integrator, q, v)
         vibration = 0.0_wp
         do while (integrator%t < duration .and. integrator%statistics%steps < 1000)
            call integrator%step(system, work, duration, error)
            call check_no_error(error, 'step')
            if (allocated(error)) return
            do j = 1, 10
               call integrator%interpolate(integrator%t_before + 0.1_wp*j*(integrator%t - integrator%t_before), q, v, w)
               vibration = max(vibration, maxval(abs(q(5:))))
            end do
         end do
         call integrator%interpolate(integrator%t, q, v, w)
         call check(integrator%t >= duration .and. integrator%statistics%steps < 500, 'stiff: few steps, but '// &
            & as_text(int(integrator%statistics%steps))//' to t = '//as_text(integrator%t, 3))
         call check_close(norm2(q(3:4) - reference%q(3:4)), 0.0_wp, tolerance(i), 'stiff: the slow motion')
         ! The beam's own sag is 5e-11
         call check_close(vibration, 0.0_wp, 1.0e-3_wp*tolerance(i), 'stiff: no vibration between the steps')
         deallocate (integrator)
      end do
   end subroutine test_stiff

   !> All coordinates and the work, as Adams finds them.
   subroutine test_agreement()
      integer, parameter :: fidelities(3) = [0, fidelity_kg, fidelity_linear]
      real(wp), parameter :: duration = 0.15_wp
      type(radau_type), allocatable :: integrator
      type(run_type) :: outcome, reference
      integer :: i
      do i = 1, 3
         allocate (integrator)
         call run_reference(crank_with(fidelities(i), soft, .true.), duration, reference)
         call run(crank_with(fidelities(i), soft, .true.), integrator, 1.0e-10_wp, duration, outcome)
         deallocate (integrator)
         call check_close(maxval(abs(outcome%q - reference%q)), 0.0_wp, 1.0e-11_wp, 'all coordinates as by Adams')
         call check_close(maxval(abs(outcome%v - reference%v)), 0.0_wp, 1.0e-8_wp, 'all velocities as by Adams')
         call check_close(outcome%w, reference%w, 1.0e-8_wp, 'the work as by Adams')
      end do
   end subroutine test_agreement

   !> The first and the largest step are what is asked for, the end is met to the bit, and what the counts tell is true.
   subroutine test_limits_of_step()
      type(radau_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      integer :: steps
      real(wp) :: largest, t
      integrator%initial_step = 1.0e-5_wp
      integrator%maximum_step = 3.0e-2_wp
      call begin(pendulum(), 1.0e-5_wp, 1.0_wp, system, work, integrator, q, v)
      steps = 0
      largest = 0.0_wp
      do while (integrator%t < 1.0_wp)
         t = integrator%t
         call integrator%step(system, work, 1.0_wp, error)
         call check_no_error(error, 'step')
         if (allocated(error)) return
         call check(abs(integrator%t_before - t) <= 0.0_wp .and. integrator%t > t, 'time goes on')
         steps = steps + 1
         if (steps == 1) call check_close(integrator%t, 1.0e-5_wp, 1.0e-20_wp, 'the first step')
         largest = max(largest, integrator%t - t)
      end do
      call check(abs(integrator%t - 1.0_wp) <= 0.0_wp, 'the end to the bit')
      call check(largest <= 3.0e-2_wp*(1 + 1.0e-12_wp) .and. largest > 2.9e-2_wp, 'the largest step')
      call check(integrator%statistics%steps == steps, 'the number of steps')
      call check_close(integrator%statistics%largest_step, largest, 1.0e-15_wp, 'the largest step is told')
      call check(integrator%statistics%highest_order == 5, 'the order is told')
   end subroutine test_limits_of_step

   !> Two runs agree to the bit.
   subroutine test_repeatable()
      type(radau_type), allocatable :: integrator
      type(run_type) :: outcomes(2)
      integer :: i
      do i = 1, 2
         allocate (integrator)
         call run(crank_with(fidelity_kg, soft, .true.), integrator, 1.0e-6_wp, 0.05_wp, outcomes(i))
         deallocate (integrator)
      end do
      call check(maxval(abs([outcomes(1)%q - outcomes(2)%q, outcomes(1)%v - outcomes(2)%v])) <= 0.0_wp &
         & .and. abs(outcomes(1)%w - outcomes(2)%w) <= 0.0_wp, 'two runs agree to the bit')
   end subroutine test_repeatable

   !> A body without mass that nothing holds is an error at the start.
   subroutine test_singular()
      type(radau_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model
      type(error_type), allocatable :: error
      real(wp) :: q(4), v(4)
      integer :: body
      model = empty_model(1.0_wp)
      body = add_rigid(model, 'nothing', 0.0_wp, 0.0_wp, nil, nil, 0.0_wp)
      system = new_system(model)
      call new_workspace(system, work)
      call first_guess(system, 0.0_wp, q, v)
      call integrator%start(system, work, 0.0_wp, 1.0_wp, q, v, error)
      call check(allocated(error), 'a body without mass that is free to move')
      if (allocated(error)) call check(index(error%message, 'singular') > 0, 'the error says so')
   end subroutine test_singular

end program test_radau
