!> The Adams integrator: a pendulum against its known motion, order of the errors in the tolerance, constraints in every step,
!> values between the steps, and what must be conserved. Momenta are sums over the nodes of a beam, written here.
program test_adams
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: beam_type, new_support, nodal_masses
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_integrator_adams, only: adams_type
   use limber_integrator_error_scales, only: new_scales, scales_type, update_scales
   use limber_model_model, only: ground, model_type
   use limber_multibody_assembly, only: first_guess
   use limber_multibody_equations_of_motion, only: mechanical_energy, position_residual, velocity_residual
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, joint_point_on_line, add_beam, add_driver, add_force, add_point_mass, add_place, &
      & add_rigid, empty_model, gauss_point, &
      & gauss_weight, join, ramp_law, wavy_law
   use swings, only: begin, g, pendulum, period, place, swing_of
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   call test_reference()
   call test_formulas()
   call test_scales()
   call test_pendulum()
   call test_order()
   call test_steps()
   call test_between()
   call test_limits_of_step()
   call test_repeatable()
   call test_stone()
   call test_flight()
   call test_work(fidelity_kg)
   call test_work(fidelity_linear)
   call test_singular()
   call finish()

contains

   !> Steps to a time and gives the state there.
   subroutine advance(integrator, system, work, stop, q, v)
      type(adams_type), intent(inout) :: integrator
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      real(wp), intent(out) :: q(:), v(:)
      type(error_type), allocatable :: error
      real(wp) :: w
      do while (integrator%t < stop)
         call integrator%step(system, work, stop, error)
         if (allocated(error)) exit
      end do
      call check_no_error(error, 'step')
      call integrator%interpolate(integrator%t, q, v, w)
   end subroutine advance

   !> The references agree with each other: period by the arithmetic-geometric mean, place at 10, and the equation itself.
   subroutine test_reference()
      real(wp) :: theta, omega, a, b, c
      integer :: i
      a = 1.0_wp
      b = sqrt(0.5_wp)
      do i = 1, 8
         c = (a + b)/2
         b = sqrt(a*b)
         a = c
      end do
      call check_close(2*acos(-1.0_wp)/a/sqrt(g), period, 1.0e-14_wp, 'period by the mean')
      theta = 0.0_wp
      omega = 0.0_wp
      call swing_of(0.0_wp, 10.0_wp, theta, omega)
      call check(maxval(abs([cos(theta), sin(theta)] - place)) <= 1.0e-11_wp, 'place at 10 by the equation')
   end subroutine test_reference

   !> The formulas themselves, on a bead under a force of time alone that turns round within a hundredth of a second, so that
   !> steps of all kinds occur, rejected ones too. Then f is what it is however good the prediction: the corrected velocity is
   !> that before plus the integral of the polynomial through the new and the last k values of f, and so are the values between.
   subroutine test_formulas()
      real(wp), parameter :: tolerance = 1.0e-8_wp, sharp = 100.0_wp, middle = 1.0_wp, duration = 2.5_wp
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), scale(:), place_alone(:)
      ! Times before that of the last step, summed from the steps so that no digit is lost, and accelerations; the newest first
      real(wp) :: t(0:13), f(2, 0:13), before(2), between, expected(2), w, worst(5)
      integer :: bead, place, i, k
      model = empty_model(1.0_wp)
      bead = add_point_mass(model, 'bead', 1.0_wp, nil)
      place = add_place(model, 'bead.origin', bead, nil)
      call add_force(model, place, ramp_law(1.0_wp, sharp, middle), wavy_law(0.1_wp, 0.0_wp, 0.5_wp, 7.0_wp))
      call begin(model, tolerance, duration, system, work, integrator, q, v)
      t = 0.0_wp
      f = 0.0_wp
      f(:, 0) = integrator%yp(3:4)
      worst = 0.0_wp
      do while (integrator%t < duration)
         before = integrator%y(3:4)
         scale = integrator%scales%value(3:4)
         call integrator%step(system, work, duration, error)
         call check_no_error(error, 'step')
         if (allocated(error)) return
         k = integrator%k_last
         t = [0.0_wp, t(:12) - integrator%h_last]
         f = reshape([integrator%yp(3:4), f(:, :12)], [2, 14])
         do i = 1, k + 1
            worst(1) = max(worst(1), abs(integrator%g(i) - coefficient(t, i)))
         end do
         do i = 0, 4
            between = integrator%t_before + 0.25_wp*i*(integrator%t - integrator%t_before)
            if (i == 4) between = integrator%t
            call integrator%interpolate(between, q, v, w)
            place_alone = q + 1.0_wp
            call integrator%interpolate_place(between, place_alone, v, w)
            worst(5) = max(worst(5), maxval(abs(place_alone - q)))
            expected = integrator%y(3:4) - integral(t, f, k, between - integrator%t, 0.0_wp)
            worst(2) = max(worst(2), maxval(abs(v - expected)))
            if (i == 0) worst(3) = max(worst(3), maxval(abs(v - before)))
         end do
         ! The local error is the difference of two correctors; that of the velocities is a part of it
         expected = integrator%h_last*(integrator%g(k) - integrator%g(k + 1))*integrator%phi(3:4, k + 1)
         worst(4) = max(worst(4), norm2(expected/scale))
      end do
      call check_close(worst(1), 0.0_wp, 1.0e-11_wp, 'coefficients g')
      call check_close(worst(2), 0.0_wp, 1.0e-12_wp, 'values between the steps are those of the polynomial')
      call check_close(worst(3), 0.0_wp, 1.0e-12_wp, 'the polynomial begins where the last step ended')
      call check_close(worst(5), 0.0_wp, 1.0e-15_wp, 'places alone')
      call check_close(worst(4), 0.5_wp*tolerance, 0.5_wp*tolerance*(1 + 1.0e-6_wp), 'the local error of accepted steps')
      call check(integrator%statistics%rejected > 0, 'some steps are rejected')
      call check(integrator%statistics%highest_order >= 8, 'high orders occur')
      ! Velocity: the logarithm of cosh
      call check_close(v(1), (duration - 2*middle) + (log1p_of(exp(-2*sharp*(duration - middle))) &
         & - log1p_of(exp(-2*sharp*middle)))/sharp, 1.0e-6_wp, 'the speed of the bead')
      call check_close(v(2), 0.1_wp*duration + 0.5_wp*(1 - cos(7*duration))/7, 1.0e-6_wp, 'its speed across')
   end subroutine test_formulas

   !> log(1 + x) of a tiny x.
   pure real(wp) function log1p_of(x)
      real(wp), intent(in) :: x
      log1p_of = x - x**2/2
   end function log1p_of

   !> g_i = 1/h integral over the step of (t - t_n)(t - t_{n-1})... / [(t_{n+1} - t_n)(t_{n+1} - t_{n-1})...], i - 1 factors.
   pure real(wp) function coefficient(t, i) result(g_i)
      !> t_{n+1}, t_n, ...
      real(wp), intent(in) :: t(0:)
      integer, intent(in) :: i
      integer, parameter :: pieces = 4
      real(wp) :: x, h
      integer :: p, point
      h = t(0) - t(1)
      g_i = 0.0_wp
      do p = 1, pieces
         do point = 1, 5
            x = t(1) + h*(p - 0.5_wp + 0.5_wp*gauss_point(point))/pieces
            g_i = g_i + gauss_weight(point)/(2*pieces)*product((x - t(1:i - 1))/(t(0) - t(1:i - 1)))
         end do
      end do
   end function coefficient

   !> Integral from a to b of the polynomial through the newest k + 1 values, by Lagrange.
   pure function integral(t, f, k, a, b) result(total)
      real(wp), intent(in) :: t(0:), f(:, 0:), a, b
      integer, intent(in) :: k
      integer, parameter :: pieces = 4
      real(wp) :: total(2), x, basis
      integer :: p, point, i, j
      total = 0.0_wp
      do p = 1, pieces
         do point = 1, 5
            x = a + (b - a)*(p - 0.5_wp + 0.5_wp*gauss_point(point))/pieces
            do i = 0, k
               basis = 1.0_wp
               do j = 0, k
                  if (j /= i) basis = basis*(x - t(j))/(t(i) - t(j))
               end do
               total = total + (b - a)*gauss_weight(point)/(2*pieces)*basis*f(:, i)
            end do
         end do
      end do
   end function integral

   !> Scales: lengths and directions fixed; speeds, deflections and their rates at least a floor, raised to what occurs, never
   !> lowered; for a damping integrator the rate of a coordinate at least that of its vibration with the deflection's scale.
   subroutine test_scales()
      type(beam_type), parameter :: beam = beam_type(ea=4.0e3_wp, ei=1.0_wp, rho_a=1.0_wp, length=2.0_wp, elements=6)
      type(model_type) :: model
      type(system_type) :: system
      type(scales_type) :: scales
      type(error_type), allocatable :: error
      real(wp) :: deflection, omega(2), rate(2), expected(12)
      integer :: body, i
      logical :: damping
      model = empty_model(3.0_wp)
      body = add_beam(model, 'beam', beam, reduction_type(support=new_support('PINNED-ROLLER'), bending=1, axial=1), nil, &
         & 0.0_wp, error)
      call check_no_error(error, 'beam')
      system = new_system(model)
      associate (field => model%bodies(body)%field)
         deflection = 1.0e-3_wp*2.0_wp/max(maxval(abs(field%w)), maxval(abs(field%u)))
         omega = sqrt([field%omega2_bending(1), field%omega2_axial(1)])
      end associate
      call check(omega(2) > 20*omega(1), 'the axial vibration is fast')
      do i = 1, 2
         damping = i == 2
         scales = new_scales(system, 1.5_wp, damping)
         rate = merge(omega, omega(1), damping)
         expected = [3.0_wp, 3.0_wp, 1.0_wp, 1.0_wp, deflection, deflection, 2.0_wp, 2.0_wp, 2.0_wp/3.0_wp, 2.0_wp/3.0_wp, &
            & deflection*rate]
         call check(maxval(abs(scales%value/expected - 1)) <= 1.0e-14_wp, 'scales at first')
         call update_scales(system, [9.0_wp, 9.0_wp, 1.0_wp, 0.0_wp, -5*deflection, 0.0_wp], &
            & [1.0_wp, -1.0_wp, 0.0_wp, 4.0_wp, 0.0_wp, -7*deflection*omega(1)], scales)
         call update_scales(system, [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], spread(0.0_wp, 1, 6), scales)
         rate = merge(max(7*omega(1), 5*omega), 7*omega(1), damping)
         expected = [3.0_wp, 3.0_wp, 1.0_wp, 1.0_wp, 5*deflection, 5*deflection, 12.0_wp, 12.0_wp, 4.0_wp, 4.0_wp, &
            & deflection*rate]
         call check(maxval(abs(scales%value/expected - 1)) <= 1.0e-14_wp, 'scales raised')
      end do
   end subroutine test_scales

   !> At t = 10, and as it passes the lowest point after a quarter and three quarters of a period, where it is fastest.
   subroutine test_pendulum()
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), v(:)
      call begin(pendulum(), 1.0e-11_wp, 10.0_wp, system, work, integrator, q, v)
      call advance(integrator, system, work, 0.25_wp*period, q, v)
      call check(maxval(abs(q(3:4) - [0.0_wp, -1.0_wp])) <= 1.0e-9_wp, 'lowest point after a quarter of the period')
      call check(maxval(abs(v(3:4) - [-sqrt(2*g), 0.0_wp])) <= 1.0e-8_wp, 'its speed there')
      call advance(integrator, system, work, 0.5_wp*period, q, v)
      call check(maxval(abs(q(3:4) - [-1.0_wp, 0.0_wp])) <= 1.0e-9_wp, 'turning point after half of it')
      call advance(integrator, system, work, 2.75_wp*period, q, v)
      call check(maxval(abs(q(3:4) - [0.0_wp, -1.0_wp])) <= 1.0e-8_wp, 'lowest point after two periods and three quarters')
      call check(maxval(abs(v(3:4) - [sqrt(2*g), 0.0_wp])) <= 1.0e-7_wp, 'its speed there')
      call advance(integrator, system, work, 10.0_wp, q, v)
      call check(abs(integrator%t - 10.0_wp) <= 0.0_wp, 'the end to the bit')
      call check_close(q(3), place(1), 1.0e-8_wp, 'x(10)')
      call check_close(q(4), place(2), 1.0e-8_wp, 'y(10)')
      call check(maxval(abs(q(1:2))) <= 1.0e-14_wp, 'the pin stays')
   end subroutine test_pendulum

   !> The error at the end is proportional to the tolerance: slope of its logarithm over four tolerances.
   subroutine test_order()
      real(wp), parameter :: tolerance(4) = [1.0e-4_wp, 1.0e-6_wp, 1.0e-8_wp, 1.0e-10_wp]
      type(adams_type), allocatable :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: error(4), x(4), y(4), slope
      integer :: i, steps(4)
      do i = 1, 4
         allocate (integrator)
         call begin(pendulum(), tolerance(i), 10.0_wp, system, work, integrator, q, v)
         call advance(integrator, system, work, 10.0_wp, q, v)
         error(i) = norm2(q(3:4) - place)
         steps(i) = int(integrator%statistics%steps)
         deallocate (integrator)
      end do
      x = log(tolerance)
      y = log(error)
      slope = sum((x - sum(x)/4)*(y - sum(y)/4))/sum((x - sum(x)/4)**2)
      call check(slope >= 0.7_wp .and. slope <= 1.3_wp, 'the error follows the tolerance')
      call check(all(error(2:) < 0.2_wp*error(:3)), 'the error falls with the tolerance')
      call check(all(error <= 1.0e4_wp*tolerance), 'the error is not far from the tolerance')
      call check(all(steps(2:) > steps(:3)), 'a smaller tolerance takes more steps')
      call check(steps(4) < 1200, 'high orders keep the number of steps low')
   end subroutine test_order

   !> In every step: constraints at round-off, u of unit length, u' square to it, energy.
   subroutine test_steps()
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: w, worst(5), kinetic, potential, before
      call begin(pendulum(), 1.0e-11_wp, 10.0_wp, system, work, integrator, q, v)
      worst = 0.0_wp
      do while (integrator%t < 10.0_wp)
         before = integrator%t
         call integrator%step(system, work, 10.0_wp, error)
         call check_no_error(error, 'step')
         if (allocated(error)) return
         call check(abs(integrator%t_before - before) <= 0.0_wp .and. integrator%t > before, 'time goes on')
         call integrator%interpolate(integrator%t, q, v, w)
         call place_frames(system%model, system%layout, integrator%t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         call update_jacobians(system, work)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         worst = max(worst, [position_residual(system, work), velocity_residual(system, work, v), abs(norm2(q(3:4)) - 1), &
            & abs(dot_product(q(3:4), v(3:4))), abs(kinetic + potential)])
         call check(abs(w) <= 0.0_wp, 'no work is put in')
      end do
      call check_close(worst(1), 0.0_wp, 1.0e-14_wp, 'position constraints in every step')
      call check_close(worst(2), 0.0_wp, 1.0e-13_wp, 'velocity constraints in every step')
      call check_close(worst(3), 0.0_wp, 2.3e-16_wp, 'u of unit length in every step')
      call check_close(worst(4), 0.0_wp, 4.0e-15_wp, 'u'' square to u in every step')
      call check_close(worst(5), 0.0_wp, 1.0e-8_wp*g, 'energy in every step')
      call check(worst(5) > 0.0_wp, 'the energy is not that of nothing')
      call check_close(integrator%statistics%position_residual, worst(1), 1.0e-14_wp, 'the residual that the integrator tells')
   end subroutine test_steps

   !> Between the steps the error is no larger than at the steps, at nine places of each step.
   subroutine test_between()
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: w, t, last, theta, omega, at_steps(2), between(2), found(2)
      integer :: i
      call begin(pendulum(), 1.0e-8_wp, 10.0_wp, system, work, integrator, q, v)
      last = 0.0_wp
      theta = 0.0_wp
      omega = 0.0_wp
      at_steps = 0.0_wp
      between = 0.0_wp
      do while (integrator%t < 10.0_wp)
         call integrator%step(system, work, 10.0_wp, error)
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
               at_steps = max(at_steps, found)
            else
               between = max(between, found)
            end if
         end do
      end do
      call check(all(at_steps > 1.0e-9_wp), 'errors at the steps can be seen')
      call check_close(between(1), 0.0_wp, 2*at_steps(1), 'coordinates between the steps')
      call check_close(between(2), 0.0_wp, 2*at_steps(2), 'velocities between the steps')
   end subroutine test_between

   !> The first and the largest step are what is asked for, and what the counts tell is true.
   subroutine test_limits_of_step()
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      integer :: steps
      real(wp) :: smallest, largest, t
      integrator%initial_step = 1.0e-5_wp
      integrator%maximum_step = 3.0e-3_wp
      call begin(pendulum(), 1.0e-6_wp, 1.0_wp, system, work, integrator, q, v)
      steps = 0
      smallest = huge(smallest)
      largest = 0.0_wp
      do while (integrator%t < 1.0_wp)
         t = integrator%t
         call integrator%step(system, work, 1.0_wp, error)
         call check_no_error(error, 'step')
         if (allocated(error)) return
         steps = steps + 1
         if (steps == 1) call check_close(integrator%t, 1.0e-5_wp, 1.0e-20_wp, 'the first step')
         if (integrator%t < 1.0_wp) smallest = min(smallest, integrator%t - t)
         largest = max(largest, integrator%t - t)
      end do
      call check(largest <= 3.0e-3_wp*(1 + 1.0e-12_wp) .and. largest > 2.0e-3_wp, 'the largest step')
      call check(integrator%statistics%steps == steps, 'the number of steps')
      call check_close(integrator%statistics%largest_step, largest, 1.0e-15_wp, 'the largest step is told')
      call check(integrator%statistics%smallest_step <= smallest*(1 + 1.0e-9_wp), 'the smallest step is told')
      call check(integrator%statistics%highest_order >= 3 .and. integrator%statistics%highest_order <= 12, 'the order')
      ! One evaluation to start with, two for each step, one for each that was rejected
      call check(work%evaluations == 1 + 2*steps + integrator%statistics%rejected, 'the evaluations')
   end subroutine test_limits_of_step

   !> Two runs agree to the bit.
   subroutine test_repeatable()
      type(adams_type), allocatable :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), v(:), first(:)
      integer :: run
      do run = 1, 2
         allocate (integrator)
         call begin(slider_crank(fidelity_kg), 1.0e-6_wp, 0.05_wp, system, work, integrator, q, v)
         call advance(integrator, system, work, 0.05_wp, q, v)
         if (run == 1) first = [q, v]
         deallocate (integrator)
      end do
      call check(maxval(abs([q, v] - first)) <= 0.0_wp, 'two runs agree to the bit')
   end subroutine test_repeatable

   !> Without constraints: a stone whose frame is not at its centre flies along a parabola and spins evenly; a point mass too.
   subroutine test_stone()
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model
      real(wp), allocatable :: q(:), v(:)
      real(wp), parameter :: centre(2) = [0.3_wp, -0.2_wp], spin = 5.0_wp, angle = 0.4_wp, t = 2.0_wp
      real(wp) :: u(2), start(2), speed(2), expected(2)
      integer :: stone, bead
      model = empty_model(1.0_wp)
      model%gravity = [1.5_wp, -g]
      stone = add_rigid(model, 'stone', 2.0_wp, 0.3_wp, centre, [0.1_wp, 0.2_wp], angle)
      model%bodies(stone)%spin = spin
      model%bodies(stone)%velocity = [3.0_wp, 7.0_wp]
      bead = add_point_mass(model, 'bead', 0.1_wp, [-1.0_wp, 0.0_wp])
      model%bodies(bead)%velocity = [-2.0_wp, 4.0_wp]
      u = [cos(angle), sin(angle)]
      start = [0.1_wp, 0.2_wp] + arm(u, centre)
      speed = [3.0_wp, 7.0_wp] + spin*arm(u, [-centre(2), centre(1)])
      call begin(model, 1.0e-11_wp, t, system, work, integrator, q, v)
      call advance(integrator, system, work, t, q, v)
      u = [cos(angle + spin*t), sin(angle + spin*t)]
      call check(maxval(abs(q(3:4) - u)) <= 1.0e-9_wp, 'the stone spins evenly')
      expected = start + speed*t + model%gravity*t**2/2 - arm(u, centre)
      call check(maxval(abs(q(1:2) - expected)) <= 1.0e-8_wp, 'its centre flies along a parabola')
      expected = [-1.0_wp, 0.0_wp] + [-2.0_wp, 4.0_wp]*t + model%gravity*t**2/2
      call check(maxval(abs(q(5:6) - expected)) <= 1.0e-11_wp, 'the bead too')
   end subroutine test_stone

   !> Vector with the components p in the frame of u.
   pure function arm(u, p) result(x)
      real(wp), intent(in) :: u(2), p(2)
      real(wp) :: x(2)
      x = [u(1)*p(1) - u(2)*p(2), u(2)*p(1) + u(1)*p(2)]
   end function arm

   !> Linear momentum (2) and angular momentum about the fixed origin of the only body, a beam: sums over its nodes.
   pure function momenta(model, q, v) result(momentum)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: q(:), v(:)
      real(wp) :: momentum(3), p(2), rate(2), x(2), speed(2), omega
      real(wp) :: mass(0:model%bodies(1)%beam%elements)
      integer :: i, nb, n
      associate (body => model%bodies(1))
         mass = nodal_masses(body%beam)
         nb = body%reduced%bending
         n = body%reduced%n
         momentum = 0.0_wp
         omega = q(3)*v(4) - q(4)*v(3)
         do i = 0, body%beam%elements
            p(1) = body%field%s(i) - body%choice%origin + dot_product(body%field%u(i, :), q(5 + nb:4 + n))
            p(2) = dot_product(body%field%w(i, :), q(5:4 + nb))
            rate(1) = dot_product(body%field%u(i, :), v(5 + nb:4 + n))
            rate(2) = dot_product(body%field%w(i, :), v(5:4 + nb))
            x = q(1:2) + arm(q(3:4), p)
            speed = v(1:2) + arm(q(3:4), rate + omega*[-p(2), p(1)])
            momentum(1:2) = momentum(1:2) + mass(i)*speed
            momentum(3) = momentum(3) + mass(i)*(x(1)*speed(2) - x(2)*speed(1))
         end do
      end associate
   end function momenta

   !> A free beam that spins, flies and vibrates without weight: momenta and energy stay. The frame of clamped-free modes is
   !> tied to one end, that of free-free modes floats; both must do.
   subroutine test_flight()
      character(12), parameter :: supports(2) = [character(12) :: 'FREE-FREE', 'CLAMPED-FREE']
      type(beam_type), parameter :: beam = beam_type(ea=4.0e3_wp, ei=1.0_wp, rho_a=1.0_wp, length=1.0_wp, elements=12)
      real(wp), parameter :: duration = 1.0_wp
      type(adams_type), allocatable :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(model_type) :: model
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: first(3), last(3), energy(2), kinetic, potential, bent
      integer :: body, i
      do i = 1, 2
         model = empty_model(1.0_wp)
         choice = reduction_type(support=new_support(trim(supports(i))), bending=2, axial=2, geometric_elements=6, &
            & fidelity=fidelity_linear, origin=0.2_wp)
         body = add_beam(model, 'beam', beam, choice, [0.3_wp, -0.4_wp], 0.5_wp, error)
         call check_no_error(error, 'beam')
         model%bodies(body)%velocity = [0.5_wp, 1.0_wp]
         model%bodies(body)%spin = 4.0_wp
         system = new_system(model)
         call new_workspace(system, work)
         allocate (q(system%layout%nq), v(system%layout%nq), integrator)
         call first_guess(system, 0.0_wp, q, v)
         q(5) = 0.03_wp
         v(6) = -0.4_wp
         integrator%tolerance = 1.0e-11_wp
         call integrator%start(system, work, 0.0_wp, duration, q, v, error)
         call check_no_error(error, 'start')
         first = momenta(model, q, v)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         energy(1) = kinetic + potential
         bent = potential
         call advance(integrator, system, work, duration, q, v)
         last = momenta(model, q, v)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         energy(2) = kinetic + potential
         call check(maxval(abs(last(1:2) - first(1:2))) <= 1.0e-8_wp*norm2(first(1:2)), supports(i)//': linear momentum')
         call check_close(last(3), first(3), 1.0e-8_wp*abs(first(3)), supports(i)//': angular momentum')
         call check_close(energy(2), energy(1), 1.0e-8_wp*energy(1), supports(i)//': energy')
         call check(abs(potential - bent) > 1.0e-3_wp*energy(1), supports(i)//': energy went to and fro')
         call check(abs(first(3)) > 0.1_wp .and. norm2(first(1:2)) > 0.5_wp, supports(i)//': there is something to conserve')
         deallocate (q, v, integrator)
      end do
   end subroutine test_flight

   !> A driven slider-crank with a flexible rod, under weight and a load.
   function slider_crank(fidelity) result(model)
      integer, intent(in) :: fidelity
      type(model_type) :: model
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: crank, rod, slider
      model = empty_model(0.5_wp)
      model%gravity = [0.0_wp, -g]
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=2, geometric_elements=2, &
         & fidelity=fidelity)
      crank = add_rigid(model, 'crank', 0.4_wp, 2.0e-3_wp, [0.1_wp, 0.01_wp], nil, 0.9_wp)
      rod = add_beam(model, 'rod', beam_type(ea=5.0e4_wp, ei=1.2_wp, rho_a=0.6_wp, length=0.5_wp, elements=12), choice, &
         & [0.2_wp, 0.1_wp], -0.3_wp, error)
      call check_no_error(error, 'rod')
      slider = add_point_mass(model, 'slider', 0.3_wp, [0.6_wp, 0.0_wp])
      call join(model, 'axle', joint_revolute, crank, nil, ground, nil)
      call join(model, 'crank-pin', joint_revolute, rod, nil, crank, [0.2_wp, 0.0_wp])
      call join(model, 'wrist-pin', joint_revolute, rod, [0.5_wp, 0.0_wp], slider, nil)
      call join(model, 'slide', joint_point_on_line, slider, nil, ground, nil, 0.05_wp)
      call add_driver(model, 'motor', crank, wavy_law(0.9_wp, 20.0_wp, 0.3_wp, 5.0_wp))
      call add_force(model, model%joints(3)%points(2), wavy_law(-3.0_wp, 0.0_wp, 2.0_wp, 30.0_wp), &
         & wavy_law(0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp))
   end function slider_crank

   !> What motor, load and the force of the model k_g put in is what the mechanism has more.
   subroutine test_work(fidelity)
      integer, intent(in) :: fidelity
      real(wp), parameter :: duration = 0.15_wp
      type(adams_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: w, start, kinetic, potential, worst, most, positions
      call begin(slider_crank(fidelity), 1.0e-10_wp, duration, system, work, integrator, q, v)
      call mechanical_energy(system, work, q, v, kinetic, potential)
      start = kinetic + potential
      worst = 0.0_wp
      most = 0.0_wp
      positions = 0.0_wp
      do while (integrator%t < duration)
         call integrator%step(system, work, duration, error)
         call check_no_error(error, 'step')
         if (allocated(error)) return
         call integrator%interpolate(integrator%t, q, v, w)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         worst = max(worst, abs(kinetic + potential - start - w))
         most = max(most, abs(w))
         call place_frames(system%model, system%layout, integrator%t, q, work%kinematics)
         positions = max(positions, position_residual(system, work))
      end do
      call check(most > 0.1_wp, 'motor and load do work')
      call check_close(worst, 0.0_wp, 2.0e-8_wp*most, 'the work put in is the energy gained')
      call check_close(positions, 0.0_wp, 1.0e-14_wp, 'slider-crank: constraints in every step')
   end subroutine test_work

   !> A body without mass that nothing holds is an error at the start.
   subroutine test_singular()
      type(adams_type) :: integrator
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

end program test_adams
