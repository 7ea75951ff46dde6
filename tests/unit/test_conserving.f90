!> The conserving integrator: energy and momenta at round-off over many steps and at steps far too large, energy less work put in
!> by everything that puts work in, constraints at every step, order two at fixed steps, errors that follow the tolerance, values
!> between the steps. Usage: test_conserving [STEPS], how many are many.
program test_conserving
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_frame_reduction, only: frame_choice_type
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_integrator_conserving, only: conserving_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_radau, only: radau_type
   use limber_model_model, only: driver_type, ground, model_type
   use limber_multibody_plane_vectors, only: along, cross, turn
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_body, only: centre_moment
   use limber_multibody_equations_of_motion, only: mechanical_energy, position_residual
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, joint_point_on_line, add_beam, add_beam_place, add_driver, add_force, add_frame, &
      & add_place, add_point_mass, add_rigid, &
      & add_spring, add_torque, empty_model, join, l_frame, slider_crank, wavy_law
   use swings, only: g, pendulum, place
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   !> A run: state at its end and what went by at steps
   type :: run_type
      real(wp), allocatable :: q(:), v(:)
      !> Largest changes: energy less work of the forces of the steps over the largest energy, linear over the largest linear
      !> momentum, angular over
      !> the largest angular momentum or |r| |p| of which it is made
      real(wp) :: energy = 0.0_wp, linear = 0.0_wp, angular = 0.0_wp
      !> Energy less the work that the laws of the loads do along the way, over the largest energy
      real(wp) :: missed = 0.0_wp
      !> Work put in: its largest size; largest residual of the position constraints, over the largest |r| if that is above 1
      real(wp) :: work = 0.0_wp, residual = 0.0_wp
      !> Largest change of the kinetic energy over the largest energy
      real(wp) :: exchange = 0.0_wp
      integer :: steps = 0, rejected = 0
      real(wp) :: microseconds = 0.0_wp
   end type run_type

   integer :: many

   call read_many()
   call test_free_beam()
   call test_free_frame()
   call test_pendulum()
   call test_double_pendulum()
   call test_jointed_beams()
   call test_line()
   call test_large_steps()
   call test_work()
   call test_changing_steps()
   call test_order_of_pendulum()
   call test_order_of_loop()
   call test_order_of_beam()
   call test_tolerance()
   call test_between()
   call test_standing()
   call test_locking()
   call finish()

contains

   subroutine read_many()
      character(20) :: word
      integer :: status
      call get_command_argument(1, word)
      read (word, *, iostat=status) many
      if (status /= 0) many = 20000
   end subroutine read_many

   !> Two bars; frames at their centres, not at the joints, one centre of mass beside its frame.
   function double_pendulum() result(model)
      type(model_type) :: model
      integer :: upper, lower
      model = empty_model(1.0_wp)
      model%gravity = [0.0_wp, -g]
      upper = add_rigid(model, 'upper', 1.2_wp, 0.1_wp, nil, [0.5_wp, 0.0_wp], 0.0_wp)
      lower = add_rigid(model, 'lower', 0.8_wp, 0.07_wp, [0.05_wp, 0.1_wp], [1.0_wp, 0.5_wp], 1.5_wp)
      call join(model, 'pin', joint_revolute, upper, [-0.5_wp, 0.0_wp], ground, nil)
      call join(model, 'elbow', joint_revolute, lower, [-0.5_wp, 0.0_wp], upper, [0.5_wp, 0.0_wp])
   end function double_pendulum

   !> Adds a beam of 1.2 with two bending coordinates and axial ones that are not too fast; its frame is not at its end.
   integer function add_arm(model, name, fidelity, position, angle) result(arm)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: fidelity
      real(wp), intent(in) :: position(2), angle
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, geometric_elements=2, &
         & fidelity=fidelity, origin=0.3_wp)
      arm = add_beam(model, name, beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8), choice, position, &
         & angle, error)
      call check_no_error(error, name)
   end function add_arm

   !> Assembles a model and starts the integrator on it; free bodies fly, spin and are bent.
   subroutine begin(model, duration, speed, system, work, integrator, q, v)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: duration
      !> Scale of all speeds and deflections
      real(wp), intent(in) :: speed
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      class(integrator_type), intent(inout) :: integrator
      real(wp), allocatable, intent(out) :: q(:), v(:)
      type(error_type), allocatable :: error
      integer :: culprit, i, k, first, last
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      q = 0.0_wp
      v = 0.0_wp
      call first_guess(system, 0.0_wp, q, v)
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         v(first:first + 1) = v(first:first + 1) + speed*[1.0_wp, 0.5_wp]
         if (.not. system%layout%framed(i)) cycle
         v(first + 2:first + 3) = v(first + 2:first + 3) + 3*speed*turn(q(first + 2:first + 3))
         last = first + 3 + system%layout%n(i)
         q(first + 4:last) = [(0.06_wp*speed/k**2, k=1, system%layout%n(i))]
         if (system%layout%n(i) > 0) q(first + 3 + system%model%bodies(i)%reduced%bending + 1:last) = 1.0e-4_wp*speed
         v(first + 4:last) = 0.1_wp*speed
      end do
      call assemble(system, work, 0.0_wp, q, v, error, culprit)
      call check_no_error(error, 'assembly')
      call integrator%start(system, work, 0.0_wp, duration, q, v, error)
      call check_no_error(error, 'start')
   end subroutine begin

   !> Runs a model at steps of one length and looks at the state after every so many of them.
   subroutine run_fixed(model, h, steps, every, speed, outcome)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: h, speed
      integer, intent(in) :: steps, every
      type(run_type), intent(out) :: outcome
      type(conserving_type) :: integrator
      integrator%initial_step = h
      integrator%maximum_step = h
      integrator%tolerance = 1.0e10_wp
      call run(model, integrator, h*steps, every, speed, outcome)
      call check(outcome%rejected == 0 .and. outcome%steps == steps, 'steps of one length: '//as_text(outcome%rejected)// &
         & ' rejected, '//as_text(outcome%steps)//' of '//as_text(steps))
      call check(integrator%statistics%largest_step <= h*(1 + 1.0e-6_wp) .and. &
         & integrator%statistics%smallest_step >= h*(1 - 1.0e-6_wp), 'all of them as long as asked for')
   end subroutine run_fixed

   subroutine run(model, integrator, duration, every, speed, outcome)
      type(model_type), intent(in) :: model
      class(integrator_type), intent(inout) :: integrator
      real(wp), intent(in) :: duration, speed
      integer, intent(in) :: every
      type(run_type), intent(out) :: outcome
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: kinetic, potential, first_kinetic, first, w, linear(2), angular, first_linear(2), first_angular, largest(3), &
         & reach, began, ended
      integer :: i
      call begin(model, duration, speed, system, work, integrator, q, v)
      call mechanical_energy(system, work, q, v, first_kinetic, potential)
      first = first_kinetic + potential
      call momenta(system, q, v, first_linear, first_angular)
      largest = [first_kinetic, norm2(first_linear), abs(first_angular)]
      call cpu_time(began)
      do while (integrator%t < duration)
         call integrator%step(system, work, duration, error)
         if (allocated(error)) exit
         if (mod(integrator%statistics%steps, int(every, kind(integrator%statistics%steps))) /= 0) cycle
         call integrator%interpolate(integrator%t, q, v, w)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         call momenta(system, q, v, linear, angular)
         reach = maxval([(norm2(q(system%layout%q(i):system%layout%q(i) + 1)), i=1, size(system%layout%q))])
         largest = max(largest, [kinetic, norm2(linear), max(abs(angular), reach*norm2(linear))])
         outcome%missed = max(outcome%missed, abs(kinetic + potential - first - w))
         outcome%energy = max(outcome%energy, abs(kinetic + potential - first - (w - integrator%input%missed)))
         outcome%linear = max(outcome%linear, norm2(linear - first_linear))
         outcome%angular = max(outcome%angular, abs(angular - first_angular))
         outcome%exchange = max(outcome%exchange, abs(kinetic - first_kinetic))
         outcome%work = max(outcome%work, abs(w))
         call place_frames(system%model, system%layout, integrator%t, q, work%kinematics)
         outcome%residual = max(outcome%residual, position_residual(system, work)/max(1.0_wp, reach))
      end do
      call cpu_time(ended)
      call check_no_error(error, 'step')
      call integrator%interpolate(integrator%t, q, v, w)
      allocate (outcome%q, source=q)
      allocate (outcome%v, source=v)
      outcome%steps = int(integrator%statistics%steps)
      outcome%rejected = int(integrator%statistics%rejected)
      outcome%microseconds = 1.0e6_wp*(ended - began)/outcome%steps
      outcome%energy = outcome%energy/largest(1)
      outcome%missed = outcome%missed/largest(1)
      outcome%exchange = outcome%exchange/largest(1)
      outcome%linear = outcome%linear/largest(2)
      outcome%angular = outcome%angular/largest(3)
   end subroutine run

   !> Momenta of all bodies in the fixed axes, the angular one about the fixed origin: from the invariants, not by the kernels of
   !> the integrator.
   pure subroutine momenta(system, q, v, linear, angular)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:), v(:)
      real(wp), intent(out) :: linear(2), angular
      real(wp) :: p(2), c(2), omega
      integer :: i, first, last
      linear = 0.0_wp
      angular = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         associate (body => system%model%bodies(i)%reduced)
            p = body%mass*v(first:first + 1)
            if (system%layout%framed(i)) then
               last = first + 3 + body%n
               associate (u => q(first + 2:first + 3), eta => q(first + 4:last), rate => v(first + 4:last))
                  omega = cross(u, v(first + 2:first + 3))
                  c = along(centre_moment(body, eta), u)
                  p = p + omega*turn(c) + along(matmul(body%c, rate), u)
                  angular = angular + cross(c, v(first:first + 1)) + dot_product(body%e - matmul(body%skew, eta), rate) &
                     & + (body%i0 + 2*dot_product(body%d, eta) + dot_product(eta, eta))*omega
                  if (body%spinning) angular = angular - dot_product(eta, matmul(body%rotary, eta))*omega
               end associate
            end if
            linear = linear + p
            angular = angular + cross(q(first:first + 1), p)
         end associate
      end do
   end subroutine momenta

   subroutine report(outcome, name)
      type(run_type), intent(in) :: outcome
      character(*), intent(in) :: name
      print '(2a,i0,a,3es10.2,a,es10.2,a,f7.2,a)', name, ', ', outcome%steps, ' steps: energy, linear, angular', outcome%energy, &
         & outcome%linear, outcome%angular, '; constraints', outcome%residual, ';', outcome%microseconds, ' us a step'
   end subroutine report

   subroutine test_free_beam()
      type(model_type) :: model
      type(run_type) :: outcome
      integer :: fidelity, steps, arm
      do fidelity = fidelity_linear, fidelity_kg
         model = empty_model(1.2_wp)
         arm = add_arm(model, 'arm', fidelity, [-0.3_wp, 0.7_wp], -1.1_wp)
         steps = merge(many, 2000, fidelity == fidelity_linear)
         call run_fixed(model, 1.0e-3_wp, steps, max(1, steps/10000), 1.0_wp, outcome)
         call report(outcome, 'free beam of fidelity '//as_text(fidelity))
         call check_close(outcome%energy, 0.0_wp, 1.0e-10_wp, 'free beam: energy')
         call check_close(outcome%linear, 0.0_wp, 1.0e-10_wp, 'free beam: linear momentum')
         call check_close(outcome%angular, 0.0_wp, 1.0e-10_wp, 'free beam: angular momentum')
         call check(outcome%exchange > 1.0e-2_wp, 'it bends to and fro')
         call check((outcome%work > 0.0_wp) .eqv. fidelity == fidelity_kg, 'work is put in by the model k_g only')
      end do
   end subroutine test_free_beam

   !> A frame whose coordinates bend and stretch it, with masses that have moments of inertia.
   subroutine test_free_frame()
      type(model_type) :: model
      type(run_type) :: outcome
      type(frame_choice_type) :: choice
      type(error_type), allocatable :: error
      integer :: fidelity, frame
      do fidelity = fidelity_linear, fidelity_kg
         model = empty_model(1.2_wp)
         choice%modes = 2
         choice%fidelity = fidelity
         choice%accelerations = .true.
         frame = add_frame(model, 'frame', l_frame(), choice, [-0.3_wp, 0.7_wp], -1.1_wp, error)
         call check_no_error(error, 'frame')
         call run_fixed(model, 1.0e-3_wp, 2000, 1, 0.3_wp, outcome)
         call report(outcome, 'free frame of fidelity '//as_text(fidelity))
         call check_close(outcome%energy, 0.0_wp, 1.0e-10_wp, 'free frame: energy')
         call check_close(outcome%linear, 0.0_wp, 1.0e-10_wp, 'free frame: linear momentum')
         call check_close(outcome%angular, 0.0_wp, 1.0e-10_wp, 'free frame: angular momentum')
         call check(outcome%exchange > 1.0e-3_wp, 'it bends to and fro')
      end do
   end subroutine test_free_frame

   subroutine test_pendulum()
      type(run_type) :: outcome
      call run_fixed(pendulum(), 1.0e-2_wp, many, max(1, many/10000), 0.0_wp, outcome)
      call report(outcome, 'pendulum')
      call check_close(outcome%energy, 0.0_wp, 1.0e-10_wp, 'pendulum: energy')
      call check_close(outcome%residual, 0.0_wp, 2.0e-15_wp, 'pendulum: constraints')
      call check(outcome%linear > 0.1_wp .and. outcome%exchange > 0.9_wp, 'it swings')
   end subroutine test_pendulum

   subroutine test_double_pendulum()
      type(run_type) :: outcome
      call run_fixed(double_pendulum(), 2.0e-3_wp, max(20000, many/20), 20, 0.0_wp, outcome)
      call report(outcome, 'double pendulum')
      call check_close(outcome%energy, 0.0_wp, 1.0e-10_wp, 'double pendulum: energy')
      call check_close(outcome%residual, 0.0_wp, 2.0e-15_wp, 'double pendulum: constraints')
      call check(outcome%angular > 0.1_wp .and. outcome%exchange > 0.5_wp, 'it tumbles')
   end subroutine test_double_pendulum

   !> Two free beams on a pin, and a spring between them: inner forces change no momentum.
   function jointed_beams() result(model)
      type(model_type) :: model
      integer :: a, b, points(2)
      model = empty_model(1.2_wp)
      a = add_arm(model, 'a', fidelity_linear, [-0.3_wp, 0.7_wp], -0.4_wp)
      b = add_arm(model, 'b', fidelity_linear, [0.4_wp, 0.2_wp], 1.1_wp)
      call join(model, 'pin', joint_revolute, a, [1.2_wp, 0.0_wp], b, nil)
      points(1) = add_beam_place(model, 'a.middle', a, 0.55_wp)
      points(2) = add_beam_place(model, 'b.end', b, 1.2_wp)
      call add_spring(model, points(1), points(2), 3.0_wp, 0.8_wp, 0.0_wp)
   end function jointed_beams

   subroutine test_jointed_beams()
      type(run_type) :: outcome
      call run_fixed(jointed_beams(), 1.0e-3_wp, max(10000, many/50), 10, 1.0_wp, outcome)
      call report(outcome, 'jointed beams')
      call check_conserved(outcome, 'jointed beams')
      call check(outcome%exchange > 1.0e-2_wp, 'they fold')
   end subroutine test_jointed_beams

   subroutine check_conserved(outcome, name)
      type(run_type), intent(in) :: outcome
      character(*), intent(in) :: name
      call check_close(outcome%energy, 0.0_wp, 1.0e-11_wp, name//': energy')
      call check_close(outcome%linear, 0.0_wp, 1.0e-11_wp, name//': linear momentum')
      call check_close(outcome%angular, 0.0_wp, 1.0e-11_wp, name//': angular momentum')
      call check_close(outcome%residual, 0.0_wp, 4.0e-15_wp, name//': constraints')
   end subroutine check_conserved

   !> A bead on a line of a free body, another spring to a point mass.
   function bead_on_line() result(model)
      type(model_type) :: model
      integer :: a, b, bead, points(2)
      model = empty_model(1.0_wp)
      a = add_rigid(model, 'a', 1.3_wp, 0.2_wp, [0.3_wp, 0.1_wp], [0.1_wp, 0.2_wp], 0.4_wp)
      b = add_arm(model, 'b', fidelity_linear, [0.5_wp, 0.2_wp], 0.1_wp)
      bead = add_point_mass(model, 'bead', 0.4_wp, [0.9_wp, -0.3_wp])
      call join(model, 'slide', joint_point_on_line, a, [0.5_wp, 0.1_wp], b, [0.3_wp, 0.0_wp], 0.3_wp)
      call join(model, 'ring', joint_point_on_line, bead, nil, a, [-0.3_wp, 0.0_wp], -1.0_wp)
      points(1) = add_place(model, 'corner', a, [-0.4_wp, 0.25_wp])
      points(2) = add_beam_place(model, 'tip', b, 1.2_wp)
      call add_spring(model, points(1), points(2), 30.0_wp, 0.4_wp, 0.0_wp)
      points(2) = add_place(model, 'bead', bead, nil)
      call add_spring(model, points(2), points(1), 20.0_wp, 0.4_wp, 0.0_wp)
   end function bead_on_line

   subroutine test_line()
      type(run_type) :: outcome
      call run_fixed(bead_on_line(), 5.0e-4_wp, 10000, 10, 1.0_wp, outcome)
      call report(outcome, 'points on lines')
      call check_conserved(outcome, 'points on lines')
      call check(outcome%exchange > 0.1_wp, 'they slide')
   end subroutine test_line

   !> Twenty times the steps of the tests above.
   subroutine test_large_steps()
      type(model_type) :: model
      type(run_type) :: outcome
      type(conserving_type) :: integrator
      integer :: arm
      call run_fixed(pendulum(), 0.2_wp, 1000, 1, 0.0_wp, outcome)
      call report(outcome, 'pendulum at large steps')
      call check_close(outcome%energy, 0.0_wp, 1.0e-12_wp, 'large steps, pendulum: energy')
      call run_fixed(double_pendulum(), 4.0e-2_wp, 1000, 1, 0.0_wp, outcome)
      call report(outcome, 'double pendulum at large steps')
      call check_close(outcome%energy, 0.0_wp, 1.0e-12_wp, 'large steps, double pendulum: energy')
      model = empty_model(1.2_wp)
      arm = add_arm(model, 'arm', fidelity_linear, [-0.3_wp, 0.7_wp], -1.1_wp)
      integrator%initial_step = 2.0e-2_wp
      integrator%maximum_step = 2.0e-2_wp
      integrator%tolerance = 1.0e10_wp
      call run(model, integrator, 20.0_wp, 1, 0.5_wp, outcome)
      call report(outcome, 'free beam at large steps')
      ! Its axial vibrations, of up to ten radians a step, leave Newton now and then without a solution
      call check(outcome%rejected <= 0.3_wp*outcome%steps, 'large steps, free beam: few are divided')
      call check_conserved(outcome, 'large steps, free beam')
      call check(outcome%exchange > 1.0e-2_wp, 'large steps, free beam: it moves')
   end subroutine test_large_steps

   !> Driver, forces, torque, spring and damper at once, the rod rigid, k_g or full.
   subroutine test_work()
      type(model_type) :: model
      type(run_type) :: outcome
      type(error_type), allocatable :: error
      integer :: kind, points(2), wheel
      integer, parameter :: kinds(3) = [0, fidelity_kg, fidelity_linear]
      do kind = 1, 3
         call slider_crank(kinds(kind), 5.0e4_wp, model, error)
         call check_no_error(error, 'slider-crank')
         wheel = add_rigid(model, 'wheel', 0.3_wp, 0.01_wp, [0.02_wp, 0.0_wp], [0.3_wp, 0.4_wp], 0.0_wp)
         call join(model, 'axle of wheel', joint_revolute, wheel, nil, ground, [0.3_wp, 0.4_wp])
         points(1) = add_place(model, 'rim', wheel, [0.1_wp, 0.0_wp])
         points(2) = add_place(model, 'slider', 3, nil)
         call add_spring(model, points(1), points(2), 40.0_wp, 0.3_wp, 0.5_wp)
         call add_torque(model, wheel, wavy_law(0.2_wp, 0.3_wp, 0.2_wp, 13.0_wp))
         if (kind == 1) then
            points(2) = add_place(model, 'shoulder', 2, [0.3_wp, 0.0_wp])
         else
            points(2) = add_beam_place(model, 'shoulder', 2, 0.3_wp)
         end if
         call add_force(model, points(2), wavy_law(0.2_wp, 0.1_wp, 2.0_wp, 9.0_wp), &
            & wavy_law(-1.0_wp, 0.0_wp, 1.0_wp, 11.0_wp))
         call run_fixed(model, 1.0e-4_wp, 10000, 10, 0.0_wp, outcome)
         call report(outcome, 'work, rod of fidelity '//as_text(kinds(kind)))
         call check(outcome%work > 1.0_wp, 'there is work: '//as_text(outcome%work, 3))
         call check_close(outcome%energy, 0.0_wp, 1.0e-11_wp, 'energy less work')
         call check_close(outcome%missed, 0.0_wp, 2.0e-7_wp, 'energy less work of the laws')
         call check_close(outcome%residual, 0.0_wp, 4.0e-15_wp, 'work: constraints')
         call run_fixed(model, 4.0e-3_wp, 500, 1, 0.0_wp, outcome)
         call check_close(outcome%energy, 0.0_wp, 1.0e-11_wp, 'energy less work at large steps')
         call check(outcome%missed > 1.0e-5_wp, 'at large steps the forces miss work, and the balance of energy shows it')
      end do
   end subroutine test_work

   !> Steps that follow the tolerance keep what fixed steps keep.
   subroutine test_changing_steps()
      type(conserving_type) :: integrator
      type(run_type) :: outcome
      integrator%tolerance = 1.0e-4_wp
      call run(jointed_beams(), integrator, 2.0_wp, 1, 1.0_wp, outcome)
      call report(outcome, 'changing steps')
      call check_conserved(outcome, 'changing steps')
      call check(integrator%statistics%largest_step > 1.2_wp*integrator%statistics%smallest_step, 'steps do change')
   end subroutine test_changing_steps

   !> Slope of log error over log of step, by least squares, from errors at steps halved again and again.
   pure real(wp) function slope(error)
      real(wp), intent(in) :: error(:)
      real(wp) :: x(size(error)), y(size(error))
      integer :: i
      x = [(i*log(0.5_wp), i=1, size(error))]
      y = log(error)
      x = x - sum(x)/size(x)
      slope = sum(x*(y - sum(y)/size(y)))/sum(x**2)
   end function slope

   subroutine check_order(error, name)
      real(wp), intent(in) :: error(:)
      character(*), intent(in) :: name
      print '(2a,f7.3,a,5es10.2)', name, ': order', slope(error), '; errors', error
      call check_close(slope(error), 2.0_wp, 0.1_wp, name//': order')
   end subroutine check_order

   subroutine test_order_of_pendulum()
      type(run_type) :: outcome
      real(wp) :: error(4)
      integer :: i
      do i = 1, 4
         call run_fixed(pendulum(), 10.0_wp/(1000*2**i), 1000*2**i, 100, 0.0_wp, outcome)
         error(i) = norm2(outcome%q(3:4) - place)
      end do
      call check_order(error, 'pendulum')
   end subroutine test_order_of_pendulum

   !> The shared slider-crank without its motor: joints close a loop. Against Radau.
   subroutine test_order_of_loop()
      type(model_type) :: model
      type(error_type), allocatable :: error
      type(driver_type), allocatable :: none(:)
      call slider_crank(0, 1.0_wp, model, error)
      call check_no_error(error, 'slider-crank')
      allocate (none(0))
      call move_alloc(none, model%drivers)
      call check_against_radau(model, 0.3_wp, 100, 1.0_wp, 'closed loop')
   end subroutine test_order_of_loop

   subroutine test_order_of_beam()
      type(model_type) :: model
      integer :: arm
      model = empty_model(1.2_wp)
      model%gravity = [0.0_wp, -g]
      arm = add_arm(model, 'arm', fidelity_linear, [-0.3_wp, 0.7_wp], -1.1_wp)
      call join(model, 'pin', joint_revolute, arm, nil, ground, nil)
      call check_against_radau(model, 0.05_wp, 400, 1.0_wp, 'flexible beam')
   end subroutine test_order_of_beam

   subroutine check_against_radau(model, duration, steps, speed, name)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: duration, speed
      integer, intent(in) :: steps
      character(*), intent(in) :: name
      type(radau_type) :: radau
      type(run_type) :: outcome, reference
      real(wp) :: error(4)
      integer :: i
      radau%tolerance = 1.0e-12_wp
      call run(model, radau, duration, 1, speed, reference)
      do i = 1, 4
         call run_fixed(model, duration/(steps*2**i), steps*2**i, 10, speed, outcome)
         error(i) = maxval(abs(outcome%q - reference%q))
      end do
      call check_order(error, name)
   end subroutine check_against_radau

   subroutine test_tolerance()
      real(wp), parameter :: tolerance(3) = [1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp]
      type(conserving_type), allocatable :: integrator
      type(run_type) :: outcome
      real(wp) :: error(3), power
      integer :: i
      do i = 1, 3
         allocate (integrator)
         integrator%tolerance = tolerance(i)
         call run(pendulum(), integrator, 10.0_wp, 1, 0.0_wp, outcome)
         deallocate (integrator)
         error(i) = norm2(outcome%q(3:4) - place)
         call check(outcome%rejected <= 0.1_wp*outcome%steps, 'few steps are rejected: '//as_text(outcome%rejected)//' of '// &
            & as_text(outcome%steps))
         call check_close(outcome%energy, 0.0_wp, 1.0e-12_wp, 'energy at tolerance '//as_text(tolerance(i), 2))
      end do
      power = log(error(1)/error(3))/log(tolerance(1)/tolerance(3))
      print '(a,f6.2,a,3es10.2)', 'tolerance: power', power, '; errors', error
      ! A local error of order 3 in a method of order 2: the error falls as the power 2/3 of the tolerance
      call check_close(power, 0.667_wp, 0.15_wp, 'errors fall with the tolerance')
   end subroutine test_tolerance

   !> Values between the ends of a step: near those of a run with small steps, and the ends themselves.
   subroutine test_between()
      type(conserving_type) :: coarse, fine
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), exact(:), rate(:), before(:)
      real(wp) :: w, largest, fastest
      integer :: i
      coarse%initial_step = 1.0e-2_wp
      coarse%maximum_step = 1.0e-2_wp
      coarse%tolerance = 1.0e10_wp
      fine%initial_step = 1.0e-3_wp
      fine%maximum_step = 1.0e-3_wp
      fine%tolerance = 1.0e10_wp
      call begin(double_pendulum(), 0.3_wp, 0.0_wp, system, work, coarse, q, v)
      call begin(double_pendulum(), 0.3_wp, 0.0_wp, system, work, fine, exact, rate)
      allocate (before, source=q)
      largest = 0.0_wp
      fastest = 0.0_wp
      do i = 1, 300
         call fine%step(system, work, 0.3_wp, error)
         if (allocated(error)) exit
         if (mod(i, 10) == 1) call coarse%step(system, work, 0.3_wp, error)
         if (allocated(error)) exit
         call fine%interpolate(fine%t, exact, rate, w)
         call coarse%interpolate(min(fine%t, coarse%t), q, v, w)
         largest = max(largest, maxval(abs(q - exact)))
         fastest = max(fastest, maxval(abs(v - rate)))
         if (mod(i, 10) == 1 .and. i > 1) then
            call coarse%interpolate(coarse%t_before, q, v, w)
            call check_close(maxval(abs(q - before)), 0.0_wp, 1.0e-14_wp, 'the beginning of a step is the end of the last')
         end if
         if (mod(i, 10) == 1) call coarse%interpolate(coarse%t, before, v, w)
      end do
      call check_no_error(error, 'between')
      print '(a,2es10.2)', 'between the steps: coordinates, velocities', largest, fastest
      call check(largest <= 2.0e-3_wp .and. fastest <= 0.1_wp, 'between the steps')
   end subroutine test_between

   !> A frame of bars that cannot move.
   subroutine test_standing()
      type(model_type) :: model
      type(conserving_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      integer :: crank, rod
      model = empty_model(1.0_wp)
      crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp, nil, nil, 0.3_wp)
      rod = add_rigid(model, 'rod', 1.0_wp, 0.1_wp, nil, [0.9_wp, 0.3_wp], -0.3_wp)
      call join(model, 'axle', joint_revolute, crank, nil, ground, nil)
      call join(model, 'pin', joint_revolute, crank, [1.0_wp, 0.0_wp], rod, nil)
      call join(model, 'slide', joint_revolute, rod, [0.5_wp, 0.0_wp], ground, [1.4_wp, 0.0_wp])
      call begin(model, 10.0_wp, 0.0_wp, system, work, integrator, q, v)
      do while (integrator%t < 10.0_wp)
         call integrator%step(system, work, 10.0_wp, error)
         if (allocated(error)) exit
      end do
      call check_no_error(error, 'bars that stand')
      call check_close(maxval(abs(integrator%w)), 0.0_wp, 1.0e-12_wp, 'it stays')
   end subroutine test_standing

   !> A driven crank whose rod is too short to go round: an error that says so, not a stop.
   subroutine test_locking()
      type(model_type) :: model
      type(conserving_type) :: integrator
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      integer :: crank, rod
      model = empty_model(1.0_wp)
      crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp, nil, nil, 0.3_wp)
      rod = add_rigid(model, 'rod', 1.0_wp, 0.1_wp, [0.4_wp, 0.0_wp], [1.0_wp, 0.3_wp], -0.4_wp)
      call join(model, 'axle', joint_revolute, crank, nil, ground, nil)
      call join(model, 'pin', joint_revolute, rod, nil, crank, [1.0_wp, 0.0_wp])
      call join(model, 'slide', joint_point_on_line, rod, [0.8_wp, 0.0_wp], ground, nil, 0.0_wp)
      call add_driver(model, 'motor', crank, wavy_law(0.3_wp, 1.0_wp, 0.0_wp, 1.0_wp))
      call begin(model, 10.0_wp, 0.0_wp, system, work, integrator, q, v)
      do while (integrator%t < 10.0_wp)
         call integrator%step(system, work, 10.0_wp, error)
         if (allocated(error)) exit
      end do
      call check(allocated(error), 'a crank that locks is an error')
      if (.not. allocated(error)) return
      print '(2a)', 'locking: ', error%message
      call check(index(error%message, 'the step has shrunk to nothing at t = 0.62') == 1, 'it tells when: '//error%message)
   end subroutine test_locking

end program test_conserving
