!> Every joint and driver between every kind of bodies, at random states that keep no constraint: Jacobian, velocity and
!> acceleration equations, drift and stiffness against differences of the residual; over steps of any length the Jacobian of the
!> mean against the change of the residual.
program test_function_constraints
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_spline, only: new_spline, spline_clamped, spline_closed, spline_natural, spline_segment, spline_type
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_model_curve, only: curve_type, expression_curve, spline_curve
   use limber_model_law_integrals, only: integrate
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: coordinate_angle, coordinate_displacement, coordinate_joint_angle, driver_displacement, &
      & driver_distance, driver_joint_angle, driver_type, driver_x, driver_y, ground, model_type, term_type
   use limber_deck_operations, only: jet_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use limber_base_text, only: newline
   use limber_model_law_breaks, only: law_breaks
   use limber_multibody_discrete_motion, only: step_residual
   use limber_multibody_drivers, only: driven_origin_type
   use limber_multibody_equations_of_motion, only: position_residual
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_discrete_step, only: begin_step, new_step, discrete_step_type
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent, only: new_tangent, tangent_type
   use scenes, only: describe, joint_revolute, joint_weld, joint_point_on_line, joint_translational, joint_rod, &
      & joint_curve, joint_sliding, joint_gear, joint_rack, joint_belt, joint_coupler, add_beam, &
      & add_beam_place, add_driver, add_joint, add_place, add_point_mass, add_rigid, derivative, &
      & empty_model, random, second_derivative, wavy_law
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Step of the stencils
   real(wp), parameter :: h = 1.0e-3_wp
   real(wp), parameter :: t = 0.37_wp

   call test_splines()
   call test_curve()
   call test_levels()
   call test_tables()
   call test_scene()
   call finish()

contains

   !> Value, slopes and ends of splines; a cubic is itself.
   subroutine test_splines()
      type(spline_type) :: spline
      real(wp) :: x(7), y(7), f(0:2), s
      integer :: i
      x = [0.0_wp, 0.4_wp, 1.0_wp, 1.3_wp, 2.0_wp, 2.9_wp, 3.5_wp]
      spline = new_spline(x, x**3 - x, spline_clamped, [-1.0_wp, 3*3.5_wp**2 - 1])
      do i = 0, 30
         s = -0.2_wp + i*0.13_wp
         f = spline%evaluate(s)
         call check(maxval(abs(f - [s**3 - s, 3*s**2 - 1, 6*s])) <= 2.0e-13_wp, 'a cubic')
      end do
      y = sin(2*acos(-1.0_wp)/3.5_wp*x)
      spline = new_spline(x, y, spline_closed)
      f = spline%evaluate(0.0_wp) - spline%evaluate(3.5_wp - 1.0e-13_wp)
      call check(maxval(abs(f)) <= 1.0e-11_wp, 'a closed spline closes with two derivatives')
      call check(maxval(abs(spline%evaluate(1.7_wp) - spline%evaluate(1.7_wp - 7.0_wp))) <= 1.0e-12_wp, 'and goes on')
      spline = new_spline(x, y, spline_natural)
      f = spline%evaluate(4.5_wp) - spline%evaluate(3.5_wp)
      s = (f(0) - 0)/1.0_wp
      f = spline%evaluate(3.5_wp)
      call check_close(s, f(1), 1.0e-13_wp, 'straight beyond the end')
      call check_close(f(2), 0.0_wp, 1.0e-13_wp, 'without curvature there')
      f = spline_segment([-2.0_wp, 0.0_wp], [-2.08_wp, 0.0_wp], [0.0_wp, 0.0_wp], -1.0e-12_wp)
      call check_close(f(0), -1.04e-12_wp, 4*epsilon(1.0_wp)*1.04e-12_wp, 'a zero at a knot is approached without round-off')
   end subroutine test_splines

   !> Signed distance from a circle, and its derivatives.
   subroutine test_curve()
      type(curve_type) :: curve
      integer, parameter :: n = 90
      real(wp) :: points(2, n), f, gradient(2), hessian(2, 2), p(2), r, across(2)
      integer :: i
      do i = 1, n
         points(:, i) = 2*[cos(2*acos(-1.0_wp)*i/n), sin(2*acos(-1.0_wp)*i/n)] + [0.3_wp, -0.1_wp]
      end do
      curve = spline_curve(points, .true.)
      do i = 1, 50
         p = [random(), random()]
         r = 2 + 0.8_wp*random()
         p = p/norm2(p)
         call curve%evaluate([0.3_wp, -0.1_wp] + r*p, f, gradient, hessian)
         call check_close(f, 2 - r, 3.0e-7_wp, 'distance from a circle, positive inside')
         call check(maxval(abs(gradient + p)) <= 2.0e-5_wp, 'its gradient')
         across = [-p(2), p(1)]
         call check_close(dot_product(across, matmul(hessian, across)), -1/r, 2.0e-3_wp, 'its curvature')
      end do
   end subroutine test_curve

   !> Integrals of a wavy law, of a bend, of a jump.
   subroutine test_levels()
      type(driver_type) :: driver
      type(jet_type) :: jet
      real(wp) :: x, value
      integer :: i
      driver%law = wavy_law(0.3_wp, -0.7_wp, 2.0_wp, 9.0_wp)
      driver%initial = [0.8_wp, -0.4_wp]
      driver%integral = integrate(driver%law, 1.0_wp, 14.0_wp, [2.0_wp, 5.5_wp])
      do i = 0, 100
         x = 1 + 0.13_wp*i
         driver%level = 1
         jet = driven_motion(driver, x)
         value = 0.8_wp + first(x) - first(1.0_wp)
         call check_close(jet%value, value, 1.0e-13_wp*(1 + abs(value)), 'integral of a law')
         call check_close(jet%first, 0.3_wp - 0.7_wp*x + 2*sin(9*x), 1.0e-14_wp*10, 'the law is its derivative')
         call check_close(jet%second, -0.7_wp + 18*cos(9*x), 1.0e-13_wp*20, 'and its own derivative the second')
         driver%level = 2
         jet = driven_motion(driver, x)
         value = 0.8_wp + second(x) - second(1.0_wp) - first(1.0_wp)*(x - 1) - 0.4_wp*(x - 1)
         call check_close(jet%value, value, 2.0e-13_wp*(1 + abs(value)), 'second integral of a law')
         call check_close(jet%first, first(x) - first(1.0_wp) - 0.4_wp, 1.0e-13_wp*70, 'its first')
      end do
   end subroutine test_levels

   !> Integrals of the law of `test_levels`.
   pure real(wp) function first(x)
      real(wp), intent(in) :: x
      first = 0.3_wp*x - 0.35_wp*x**2 - 2*cos(9*x)/9
   end function first

   pure real(wp) function second(x)
      real(wp), intent(in) :: x
      second = 0.15_wp*x**2 - 0.35_wp*x**3/3 - 2*sin(9*x)/81
   end function second

   !> A table of straight pieces, of an argument that runs twice as fast, and a spline; where they bend.
   subroutine test_tables()
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      type(jet_type) :: jet
      real(wp), allocatable :: times(:)
      call read_deck_text('tables.inp', '*TABLE, NAME=bent'//newline//' 0, 1'//newline//' 1, 3'//newline//' 4, 0'//newline// &
         & '*TABLE, NAME=round, INTERPOLATION=SPLINE'//newline//' 0, 0'//newline//' 1, 1'//newline//' 2, 0'//newline// &
         & '*RIGID BODY, NAME=a, MASS=1'//newline//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=a'//newline// &
         & ' 10*bent(2*t) - 1'//newline//'*DRIVER, NAME=e, TYPE=ANGLE, BODY=a'//newline//' round(t**2)'//newline, deck, diagnostics)
      call check(diagnostics%count == 0, 'tables are read')
      if (diagnostics%count > 0) return
      allocate (times(0))
      associate (law => deck%blocks(4)%lines(1)%fields(1)%expression)
         jet = law%evaluate_jet(0.25_wp)
         call check_close(jet%value, 19.0_wp, 1.0e-14_wp*20, 'a straight piece')
         call check_close(jet%first, 40.0_wp, 1.0e-14_wp*40, 'its slope')
         jet = law%evaluate_jet(0.5_wp)
         call check_close(jet%first, -20.0_wp, 1.0e-14_wp*20, 'at a bend, the slope that follows')
         jet = law%evaluate_jet(3.0_wp)
         call check_close(jet%value, -1.0_wp, 1.0e-15_wp, 'beyond the last point')
         call check_close(law%evaluate([-7.0_wp]), 9.0_wp, 1.0e-15_wp, 'before the first')
         call law_breaks(law, -1.0_wp, 5.0_wp, times)
         call check(size(times) == 3, 'it bends three times')
         if (size(times) == 3) call check(maxval(abs(times - [0.0_wp, 0.5_wp, 2.0_wp])) <= 1.0e-15_wp, 'at its points')
      end associate
      associate (law => deck%blocks(5)%lines(1)%fields(1)%expression)
         ! the natural spline through three points: (3 x - x**3)/2 up to the middle one
         jet = law%evaluate_jet(0.8_wp)
         call check_close(jet%value, 0.5_wp*(3*0.64_wp - 0.64_wp**3), 1.0e-15_wp, 'a spline')
         call check_close(jet%first, 0.5_wp*(3 - 3*0.64_wp**2)*1.6_wp, 4.0e-15_wp, 'its slope')
         call check_close(jet%second, -3*0.64_wp*1.6_wp**2 + (3 - 3*0.64_wp**2), 1.0e-14_wp, 'and curvature')
      end associate
   end subroutine test_tables

   !> Everything between everything.
   function zoo() result(model)
      type(model_type) :: model
      type(reduction_type) :: choice
      type(beam_type) :: beam
      type(error_type), allocatable :: error
      integer, parameter :: kinds(10) = [joint_weld, joint_translational, joint_gear, joint_gear, joint_rack, joint_belt, &
         & joint_rod, joint_point_on_line, joint_curve, joint_curve]
      integer :: rod, arm, block, bead, plate, a, b, c, d, e, f, g, k
      model = empty_model(1.5_wp)
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1, geometric_elements=2, &
         & fidelity=fidelity_kg)
      rod = add_beam(model, 'rod', beam, choice, [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'rod')
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=3, geometric_elements=3, &
         & fidelity=fidelity_linear, origin=0.3_wp)
      arm = add_beam(model, 'arm', beam, choice, [-0.3_wp, 0.7_wp], -1.1_wp, error)
      call check_no_error(error, 'arm')
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      plate = add_rigid(model, 'plate', 1.0_wp, 0.2_wp, [0.0_wp, 0.1_wp], [-0.5_wp, -0.7_wp], -0.4_wp)
      a = add_beam_place(model, 'rod.end', rod, 1.2_wp)
      b = add_beam_place(model, 'rod.middle', rod, 0.55_wp)
      c = add_beam_place(model, 'arm.tip', arm, 1.2_wp)
      d = add_place(model, 'block.corner', block, [-0.4_wp, 0.25_wp])
      e = add_place(model, 'bead.origin', bead, [0.0_wp, 0.0_wp])
      f = add_place(model, 'plate.rim', plate, [0.3_wp, 0.2_wp])
      g = add_place(model, 'ground.a', ground, [0.3_wp, -0.6_wp])
      do k = 1, size(kinds)
         call link(model, 'flexible-flexible', kinds(k), b, c)
         call link(model, 'flexible-rigid', kinds(k), b, d)
         call link(model, 'rigid-flexible', kinds(k), d, c)
         call link(model, 'rigid-rigid', kinds(k), d, f)
         call link(model, 'rigid-ground', kinds(k), f, g)
         call link(model, 'ground-flexible', kinds(k), g, a)
      end do
      call add_joint(model, 'bead from block', joint_rod, e, d)
      call add_joint(model, 'bead from ground', joint_rod, e, g)
      call add_joint(model, 'bead on arm', joint_point_on_line, e, c, 0.7_wp)
      call add_joint(model, 'block on bead', joint_point_on_line, d, e, 0.7_wp)
      call add_joint(model, 'bead along arm', joint_sliding, e, c)
      call add_joint(model, 'block along rod', joint_sliding, d, a)
      call add_joint(model, 'rod along arm', joint_sliding, b, c)
      call add_joint(model, 'ground along rod', joint_sliding, g, a)
      call add_joint(model, 'hinge', joint_revolute, d, f)
      call add_joint(model, 'guide', joint_translational, f, d, 0.3_wp)
      call add_couplers(model, block, rod, plate, arm)
      call add_driver(model, 'turn', block, wavy_law(2.9_wp, -0.7_wp, 0.6_wp, -1.4_wp))
      call add_driver(model, 'angle', 0, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_joint_angle, 'hinge', [0, 0])
      call add_driver(model, 'slide', 0, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_displacement, 'guide', [0, 0])
      call add_driver(model, 'reach', 0, wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_distance, '', [c, d])
      call add_driver(model, 'lift', 0, wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_y, '', [c, 0])
      call add_driver(model, 'push', 0, wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_x, '', [e, 0])
      call add_driver(model, 'raise', 0, wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_y, '', [add_place(model, 'plate.origin', plate, [0.0_wp, 0.0_wp]), 0])
      call add_driver(model, 'shift', 0, wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp))
      call set_driver(model, driver_x, '', [add_beam_place(model, 'rod.start', rod, 0.0_wp), 0])
   end function zoo

   !> A joint of a kind with all that any kind needs.
   subroutine link(model, name, kind, first, second)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: kind, first, second
      integer :: k
      real(wp), parameter :: x(9) = [-9.0_wp, -6.0_wp, -4.0_wp, -2.0_wp, 0.0_wp, 2.0_wp, 4.0_wp, 6.0_wp, 9.0_wp]
      call add_joint(model, name//' '//achar(iachar('a') + kind), kind, first, second, 0.9_wp)
      associate (joint => model%joints(size(model%joints)))
         joint%radius = [0.4_wp, 0.25_wp]
         joint%same_direction = modulo(size(model%joints), 2) == 0
         call describe(joint, kind)
         if (kind == joint_curve .and. joint%same_direction) then
            joint%curve = expression_curve(wavy_law(0.1_wp, 0.2_wp, 0.1_wp, 0.9_wp))
         else if (kind == joint_curve) then
            joint%curve = spline_curve(reshape([([x(k), 0.05_wp*sin(x(k))], k=1, 9)], [2, 9]), .false.)
         end if
      end associate
   end subroutine link

   !> Couplers of two bodies, and of four; one with more terms than a part has room for.
   subroutine add_couplers(model, block, rod, plate, arm)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: block, rod, plate, arm
      integer :: hinge, guide, long, k
      hinge = size(model%joints) - 1
      guide = size(model%joints)
      call add_joint(model, 'coupler', joint_coupler, 0, 0)
      model%joints(size(model%joints))%terms = [term_type(2.0_wp, coordinate_angle, block), &
         & term_type(-0.7_wp, coordinate_joint_angle, hinge), term_type(0.3_wp, coordinate_displacement, guide)]
      call add_joint(model, 'driven coupler', joint_coupler, 0, 0)
      model%joints(size(model%joints))%terms = [term_type(2.0_wp, coordinate_angle, rod), &
         & term_type(-0.7_wp, coordinate_angle, plate), term_type(0.4_wp, coordinate_displacement, hinge - 2)]
      model%joints(size(model%joints))%has_law = .true.
      model%joints(size(model%joints))%law = wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp)
      long = 0
      do k = 1, hinge
         if (model%joints(k)%name == 'flexible-flexible '//achar(iachar('a') + joint_point_on_line)) long = k
      end do
      call add_joint(model, 'driven coupler of four', joint_coupler, 0, 0)
      model%joints(size(model%joints))%terms = [term_type(0.6_wp, coordinate_joint_angle, hinge), &
         & term_type(-1.1_wp, coordinate_displacement, long), term_type(0.8_wp, coordinate_angle, arm), &
         & term_type(0.9_wp, coordinate_displacement, guide), term_type(0.5_wp, coordinate_joint_angle, long)]
      model%joints(size(model%joints))%has_law = .true.
      model%joints(size(model%joints))%law = wavy_law(0.7_wp, 0.3_wp, 0.4_wp, 2.1_wp)
      call add_joint(model, 'coupler of nine terms', joint_coupler, 0, 0)
      model%joints(size(model%joints))%terms = [(term_type(0.1_wp*k, coordinate_joint_angle, long), k=1, 4), &
         & (term_type(0.2_wp - 0.1_wp*k, coordinate_displacement, guide), k=1, 4), term_type(1.0_wp, coordinate_angle, rod)]
   end subroutine add_couplers

   !> What the last driver drives.
   subroutine set_driver(model, kind, joint, points)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: kind, points(2)
      character(*), intent(in) :: joint
      integer :: i
      associate (driver => model%drivers(size(model%drivers)))
         driver%kind = kind
         driver%points = points
         do i = 1, size(model%joints)
            if (model%joints(i)%name == joint) driver%joint = i
         end do
      end associate
   end subroutine set_driver

   subroutine test_scene()
      type(system_type) :: system
      type(workspace_type) :: work
      type(tangent_type) :: tangent
      integer :: trial
      system = new_system(zoo())
      call new_workspace(system, work)
      call new_tangent(system, tangent)
      call check(origins(system) == 3, 'three drivers of origins are of their own type')
      do trial = 1, 4
         call test_state(system, work, tangent)
      end do
      call test_steps(system, work)
   end subroutine test_scene

   !> Number of drivers that move the origin of a frame itself, whatever the deflection.
   integer function origins(system) result(number)
      type(system_type), intent(in) :: system
      integer :: i
      number = 0
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (driven_origin_type)
            number = number + 1
         end select
      end do
   end function origins

   !> All derivatives at a random state.
   subroutine test_state(system, work, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(tangent_type), intent(inout) :: tangent
      real(wp), dimension(system%layout%nw) :: w, a, d, free, bound
      real(wp), dimension(system%layout%nq) :: q, v, moved
      real(wp), dimension(system%nc) :: lambda, rates, slope, gamma, drift
      real(wp) :: phi(system%nc, -2:2), g(system%nc, -2:2), force(system%layout%nw, -2:2), largest
      integer :: k, i, row, last
      call random_state(system, q, w)
      call fill(a)
      call fill(d)
      call fill(lambda)
      call velocities_of(system%layout, q, w, v)
      ! along a motion, in time
      do k = -2, 2
         call advance(system%layout, q, k*h*w + (k*h)**2/2*a, moved)
         call place_frames(system%model, system%layout, t + k*h, moved, work%kinematics)
         largest = position_residual(system, work)
         phi(:, k) = work%phi
      end do
      call motion_residual(system, work, t, q, v, a, 0*lambda, free, rates)
      slope = derivative(phi(:, -2), phi(:, -1), phi(:, 1), phi(:, 2), h)
      call compare(system, slope, rates, 1.0e-6_wp, 'velocity equation')
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            last = item%first + item%rows - 1
            call item%gamma(work%kinematics, gamma(item%first:last))
         end associate
      end do
      slope = second_derivative(phi(:, -2), phi(:, -1), phi(:, 0), phi(:, 1), phi(:, 2), h)
      call compare(system, slope, times_jacobian(system, work%jacobians, a) - gamma, 1.0e-5_wp, 'acceleration equation')
      ! along a direction in space
      do k = -2, 2
         call advance(system%layout, q, k*h*d, moved)
         call place_frames(system%model, system%layout, t, moved, work%kinematics)
         largest = position_residual(system, work)
         phi(:, k) = work%phi
         call velocities_of(system%layout, moved, w, v)
         call motion_residual(system, work, t, moved, v, a, 0*lambda, free, g(:, k))
         call motion_residual(system, work, t, moved, v, a, lambda, bound, g(:, k))
         force(:, k) = bound - free
      end do
      call velocities_of(system%layout, q, w, v)
      call motion_residual(system, work, t, q, v, a, lambda, bound, rates)
      slope = derivative(phi(:, -2), phi(:, -1), phi(:, 1), phi(:, 2), h)
      call compare(system, slope, times_jacobian(system, work%jacobians, d), 1.0e-6_wp, 'Jacobian')
      call linearise_motion(system, work, tangent, q, v, a, lambda)
      slope = derivative(g(:, -2), g(:, -1), g(:, 1), g(:, 2), h)
      drift = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item, c => tangent%constraints(i))
            do row = 1, item%rows
               if (item%bodies(1) /= ground) drift(item%first + row - 1) = drift(item%first + row - 1) &
                  & + dot_product(c%first_drift(row, :), part(system, d, item%bodies(1)))
               if (item%bodies(2) /= ground) drift(item%first + row - 1) = drift(item%first + row - 1) &
                  & + dot_product(c%second_drift(row, :), part(system, d, item%bodies(2)))
            end do
         end associate
      end do
      call compare(system, slope, drift, 1.0e-5_wp, 'drift')
      call test_stiffness(system, work, lambda, d, force)
   end subroutine test_state

   !> The change of each constraint's forces along a direction.
   subroutine test_stiffness(system, work, lambda, d, force)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: lambda(:), d(:), force(:, -2:)
      real(wp) :: k(size(d), size(d)), slope(size(d))
      real(wp), allocatable :: first(:, :), second(:, :), across(:, :)
      integer :: i, m, n, a, b
      k = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            m = size(part(system, d, item%bodies(1)))
            n = size(part(system, d, item%bodies(2)))
            allocate (first(m, m), second(n, n), across(m, n))
            first = 0.0_wp
            second = 0.0_wp
            across = 0.0_wp
            call item%stiffness(work%kinematics, lambda(item%first:item%first + item%rows - 1), first, second, across)
            a = 1
            b = 1
            if (m > 0) a = system%layout%w(item%bodies(1))
            if (n > 0) b = system%layout%w(item%bodies(2))
            k(a:a + m - 1, a:a + m - 1) = k(a:a + m - 1, a:a + m - 1) + first
            k(b:b + n - 1, b:b + n - 1) = k(b:b + n - 1, b:b + n - 1) + second
            k(a:a + m - 1, b:b + n - 1) = k(a:a + m - 1, b:b + n - 1) + across
            k(b:b + n - 1, a:a + m - 1) = k(b:b + n - 1, a:a + m - 1) + transpose(across)
            call check(item%couples() .or. .not. any(abs(across) > 0.0_wp), item%label//' says whether it couples')
            deallocate (first, second, across)
         end associate
      end do
      slope = derivative(force(:, -2), force(:, -1), force(:, 1), force(:, 2), h)
      call check(maxval(abs(slope - matmul(k, d))) <= 1.0e-6_wp*(1 + maxval(abs(slope))), 'stiffness of all joints')
      call check(maxval(abs(k - transpose(k))) <= 1.0e-11_wp*maxval(abs(k)), 'which is symmetric')
   end subroutine test_stiffness

   !> Over steps of any length.
   subroutine test_steps(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type) :: step
      real(wp), dimension(system%layout%nw) :: w, y, motion
      real(wp), dimension(system%nc) :: lambda, phi, before, expected
      real(wp) :: q(system%layout%nq), largest, length
      real(wp), parameter :: lengths(4) = [1.0e-3_wp, 0.05_wp, 0.4_wp, 1.0_wp]
      integer :: trial, i
      call new_step(system, work, step)
      do trial = 1, 4
         length = lengths(trial)
         call random_state(system, q, w)
         call fill(lambda)
         call fill(y)
         y = length*y
         do i = 1, size(system%layout%q)
            associate (at => system%layout%w(i) + 3, n => system%layout%n(i))
               y(at:at + n - 1) = 0.1_wp*y(at:at + n - 1)
            end associate
         end do
         call begin_step(system, step, t, length, t + length, q, w)
         work%kinematics%angles%anchor = step%start%angles%value
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         largest = position_residual(system, work)
         before = work%phi
         call step_residual(system, work, step, y, lambda, motion, phi)
         expected = times_jacobian(system, step%jacobians, y)
         do i = 1, size(system%constraints)
            associate (item => system%constraints(i)%item)
               if (.not. item%driven .or. item%part_of > 0) cycle
               expected(item%first) = expected(item%first) - moved_by(system, i, length)
               if (i == size(system%model%joints) + 1) expected(item%first) = phi(item%first) - before(item%first)
            end associate
         end do
         call compare(system, phi - before, expected, 3.0e-13_wp, 'change over a step')
      end do
   end subroutine test_steps

   !> What moves a constraint in time over a step.
   real(wp) function moved_by(system, constraint, length) result(change)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint
      real(wp), intent(in) :: length
      integer :: joints
      joints = size(system%model%joints)
      if (constraint > joints) then
         change = system%model%drivers(constraint - joints)%law%evaluate([t + length]) &
            & - system%model%drivers(constraint - joints)%law%evaluate([t])
      else
         change = system%model%joints(constraint)%law%evaluate([t + length]) - system%model%joints(constraint)%law%evaluate([t])
      end if
   end function moved_by

   !> Every coordinate random, deflections of a twentieth of the length; a body may have turned several times.
   subroutine random_state(system, q, w)
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: q(:), w(:)
      real(wp) :: straight(size(q)), change(size(w))
      integer :: i
      straight = 0.0_wp
      do i = 1, size(system%layout%q)
         if (system%layout%framed(i)) straight(system%layout%q(i) + 2) = 1.0_wp
      end do
      call fill(w)
      call fill(change)
      do i = 1, size(system%layout%q)
         associate (at => system%layout%w(i) + 3, n => system%layout%n(i))
            change(at:at + n - 1) = 0.05_wp*change(at:at + n - 1)
            if (system%layout%framed(i)) change(at - 1) = 3*change(at - 1)
         end associate
      end do
      call advance(system%layout, straight, change, q)
   end subroutine random_state

   subroutine fill(x)
      real(wp), intent(out) :: x(:)
      integer :: i
      do i = 1, size(x)
         x(i) = random()
      end do
   end subroutine fill

   !> The part of a vector of rates that is a body's.
   pure function part(system, vector, body) result(own)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: vector(:)
      integer, intent(in) :: body
      real(wp), allocatable :: own(:)
      integer :: n
      n = 0
      if (body /= ground) n = system%layout%rates(body) + system%layout%n(body)
      allocate (own(n))
      if (body /= ground) own = vector(system%layout%w(body):system%layout%w(body) + n - 1)
   end function part

   !> Jacobian of all constraints times a vector of rates.
   function times_jacobian(system, jacobians, vector) result(product)
      use limber_multibody_constraint, only: jacobian_type
      type(system_type), intent(in) :: system
      type(jacobian_type), intent(in) :: jacobians(:, :)
      real(wp), intent(in) :: vector(:)
      real(wp) :: product(system%nc)
      real(wp), allocatable :: own(:)
      integer :: i, side, row, rates
      product = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%bodies(side) == ground) cycle
               own = part(system, vector, item%bodies(side))
               rates = system%layout%rates(item%bodies(side))
               do row = 1, item%rows
                  product(item%first + row - 1) = product(item%first + row - 1) &
                     & + dot_product(jacobians(side, i)%z(row, :rates), own(:rates)) &
                     & + dot_product(jacobians(side, i)%eta(row, :), own(rates + 1:))
               end do
            end do
         end associate
      end do
   end function times_jacobian

   !> Compares a value for every row; names the constraint.
   subroutine compare(system, value, expected, tolerance, name)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: value(:), expected(:), tolerance
      character(*), intent(in) :: name
      integer :: i, row
      do i = 1, size(system%constraints)
         do row = system%constraints(i)%item%first, system%constraints(i)%item%first + system%constraints(i)%item%rows - 1
            call check_close(value(row), expected(row), tolerance*(1 + abs(expected(row))), &
               & name//' of '//system%constraints(i)%item%label)
         end do
      end do
   end subroutine compare

end program test_function_constraints
