!> Assembly of rough guesses: four-bar and slider-crank from guesses that are off by 0.3 rad, and the errors that name what
!> cannot be assembled or is redundant. Closure is checked with points placed here by an angle.
program test_assembly
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_linear, reduction_type
   use limber_model_model, only: place_on_line, ground, model_type
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_equations_of_motion, only: accelerations, linearise, mechanical_energy, position_residual, velocity_residual
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_point_motion, only: point_position, point_velocity
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_constraint_rank, only: assembly_type
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_compliant_constraints, only: soften_constraints
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, joint_point_on_line, add_beam, add_driver, add_joint, add_point_mass, add_rigid, &
      & constant_law, empty_model, join, wavy_law
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none
   !> What counts as assembled, relative to the scene
   real(wp), parameter :: satisfied = 1.0e-12_wp
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   call test_four_bar()
   call test_slider_crank()
   call test_spin_of_guess()
   call test_deflections()
   call test_driver()
   call test_impossible()
   call test_redundant()
   call test_many()
   call test_shared_reactions()
   call test_dead_centre()
   call test_free()
   call finish()

contains

   !> A four-bar linkage, bars 1, 3, 2.5, ground pivots at 0 and (3.2, 0); each guess of an angle may be wrong. Correct for the
   !> crank at 60 degrees: found from the two circles.
   function four_bar(errors, coupler) result(model)
      !> Errors of the guessed angles of crank, coupler and rocker
      real(wp), intent(in) :: errors(3)
      real(wp), intent(in) :: coupler
      type(model_type) :: model
      real(wp) :: a(2), b(2), d(2), half, across
      real(wp), parameter :: pivot(2) = [3.2_wp, 0.0_wp]
      integer :: crank, rod, rocker
      model = empty_model(3.2_wp)
      a = [cos(acos(0.5_wp)), sin(acos(0.5_wp))]
      d = pivot - a
      half = (3.0_wp**2 - 2.5_wp**2 + dot_product(d, d))/(2*norm2(d))
      across = sqrt(3.0_wp**2 - half**2)
      b = a + (half*d + across*[-d(2), d(1)])/norm2(d)
      crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp, [0.5_wp, 0.0_wp], [0.0_wp, 0.0_wp], atan2(a(2), a(1)) + errors(1))
      rod = add_rigid(model, 'coupler', 2.0_wp, 0.5_wp, [1.5_wp, 0.2_wp], a, atan2(b(2) - a(2), b(1) - a(1)) + errors(2))
      rocker = add_rigid(model, 'rocker', 1.5_wp, 0.4_wp, [1.2_wp, 0.0_wp], pivot, atan2(b(2), b(1) - pivot(1)) + errors(3))
      call join(model, 'left', joint_revolute, crank, nil, ground, nil)
      call join(model, 'crank-pin', joint_revolute, rod, nil, crank, [1.0_wp, 0.0_wp])
      call join(model, 'rocker-pin', joint_revolute, rod, [coupler, 0.0_wp], rocker, [2.5_wp, 0.0_wp])
      call join(model, 'right', joint_revolute, rocker, nil, ground, pivot)
   end function four_bar

   !> Assembles a model as the program does.
   subroutine put_together(model, t, system, work, q, v, error, culprit)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: t
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      real(wp), allocatable, intent(out) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      call first_guess(system, t, q, v)
      call assemble(system, work, t, q, v, error, culprit)
   end subroutine put_together

   !> Everything that an assembled state must be: closed, moving along, u of unit length and u' square to it.
   subroutine check_state(system, work, t, q, v, name)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      character(*), intent(in) :: name
      real(wp) :: gap(2), slip(2)
      integer :: i, first
      do i = 1, size(system%model%joints)
         associate (joint => system%model%joints(i), points => system%model%points)
            gap = point_position(system%model, system%layout, points(joint%points(1)), q) &
               & - point_position(system%model, system%layout, points(joint%points(2)), q)
            slip = point_velocity(system%model, system%layout, points(joint%points(1)), q, v) &
               & - point_velocity(system%model, system%layout, points(joint%points(2)), q, v)
            if (joint%place == place_on_line) then
               ! All lines here lie on the ground
               gap = [cos(joint%angle)*gap(2) - sin(joint%angle)*gap(1), 0.0_wp]
               slip = [cos(joint%angle)*slip(2) - sin(joint%angle)*slip(1), 0.0_wp]
            end if
            call check_close(norm2(gap), 0.0_wp, satisfied*system%model%length, name//': '//joint%name//' is closed')
            call check_close(norm2(slip), 0.0_wp, satisfied*system%model%length*max(1.0_wp, maxval(abs(v))), &
               & name//': '//joint%name//' moves along')
         end associate
      end do
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         call check_close(norm2(q(first:first + 1)), 1.0_wp, 4.0e-16_wp, name//': u has unit length')
         call check_close(dot_product(q(first:first + 1), v(first:first + 1)), 0.0_wp, 1.0e-14_wp*max(1.0_wp, maxval(abs(v))), &
            & name//': u'' is square to u')
      end do
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      call update_jacobians(system, work)
      call check_close(position_residual(system, work), 0.0_wp, satisfied, name//': positions')
      call check_close(velocity_residual(system, work, v), 0.0_wp, satisfied*max(1.0_wp, maxval(abs(v))), name//': velocities')
   end subroutine check_state

   !> All signs of errors of 0.3 rad; the nearest branch, the one that was guessed, is found.
   subroutine test_four_bar()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(model_type) :: model
      real(wp), allocatable :: q(:), v(:)
      integer :: signs, culprit, i
      real(wp) :: errors(3), a(2), b(2)
      do signs = 0, 7
         errors = 0.3_wp*[(merge(1, -1, btest(signs, i)), i=0, 2)]
         model = four_bar(errors, 3.0_wp)
         model%bodies(1)%spin = 2.0_wp
         call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
         call check_no_error(error, 'four-bar')
         call check(culprit == 0, 'four-bar: nothing is to blame')
         if (.not. allocated(error)) call check_state(system, work, 0.0_wp, q, v, 'four-bar')
         ! Open, not crossed: the rocker pin lies to the left of the line from the crank pin to the right pivot
         a = point_position(system%model, system%layout, model%points(model%joints(2)%points(2)), q)
         b = point_position(system%model, system%layout, model%points(model%joints(3)%points(1)), q)
         call check((3.2_wp - a(1))*(b(2) - a(2)) + a(2)*(b(1) - a(1)) > 1.0_wp, 'four-bar: the branch of the guess')
         call check(maxval(abs(v)) > 0.1_wp, 'four-bar: the guessed speed is not lost')
      end do
   end subroutine test_four_bar

   !> A driven crank, a rod guessed 0.3 rad off and a slider guessed at the wrong place; closed form of the slider.
   subroutine test_slider_crank()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp), parameter :: angle = 0.8_wp, spin = 150.0_wp, r = 0.15_wp, l = 0.3_wp
      real(wp) :: x, speed, root
      integer :: culprit, side
      do side = -1, 1, 2
         call put_together(slider_crank(0.3_wp*side, l), 0.0_wp, system, work, q, v, error, culprit)
         call check_no_error(error, 'slider-crank')
         if (allocated(error)) cycle
         call check_state(system, work, 0.0_wp, q, v, 'slider-crank')
         root = sqrt(l**2 - (r*sin(angle))**2)
         x = r*cos(angle) + root
         speed = -r*sin(angle)*spin*(1 + r*cos(angle)/root)
         call check_close(q(size(q) - 1), x, satisfied, 'slider-crank: place of the slider')
         call check_close(v(size(v) - 1), speed, satisfied*spin, 'slider-crank: its speed')
         call check(maxval(abs(q(9:8 + system%layout%n(2)))) <= 0.0_wp, 'slider-crank: the rod stays straight')
         call check(maxval(abs(v(9:8 + system%layout%n(2)))) <= 0.0_wp, 'slider-crank: the rod does not vibrate')
      end do
   end subroutine test_slider_crank

   function slider_crank(error_of_rod, length) result(model)
      real(wp), intent(in) :: error_of_rod, length
      type(model_type) :: model
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: crank, rod, slider
      model = empty_model(0.45_wp)
      beam = beam_type(ea=5.65e6_wp, ei=12.7_wp, rho_a=0.2225_wp, length=length, elements=8)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=2, geometric_elements=2, &
         & fidelity=fidelity_linear)
      ! A crank of no mass, its angle guessed by nobody: the driver knows it
      crank = add_rigid(model, 'crank', 0.0_wp, 0.0_wp, [0.0_wp, 0.0_wp], [0.01_wp, -0.02_wp], -2.0_wp)
      rod = add_beam(model, 'rod', beam, choice, [0.1_wp, 0.1_wp], -0.367_wp + error_of_rod, error)
      call check_no_error(error, 'rod')
      slider = add_point_mass(model, 'slider', 0.033375_wp, [0.3_wp, 0.02_wp])
      call join(model, 'axle', joint_revolute, crank, nil, ground, nil)
      call join(model, 'crank-pin', joint_revolute, rod, nil, crank, [0.15_wp, 0.0_wp])
      call join(model, 'wrist-pin', joint_revolute, rod, [length, 0.0_wp], slider, nil)
      call join(model, 'slide', joint_point_on_line, slider, nil, ground, nil)
      call add_driver(model, 'motor', crank, wavy_law(0.8_wp, 150.0_wp, 0.0_wp, 1.0_wp))
   end function slider_crank

   !> A guessed spin turns with the frame as the guess of its angle is corrected: u' = omega J u, and nothing along u. Otherwise
   !> the state has energy, and its points velocities, that no motion has. What the joints leave free keeps its guess.
   subroutine test_spin_of_guess()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), a(:)
      real(wp) :: kinetic, potential, omega
      integer :: bar, culprit
      model = empty_model(1.0_wp)
      bar = add_rigid(model, 'bar', 2.0_wp, 0.1_wp, [0.5_wp, 0.0_wp], [0.0_wp, 0.0_wp], 0.3_wp)
      model%bodies(bar)%spin = 10.0_wp
      call join(model, 'pin', joint_revolute, bar, nil, ground, nil)
      call join(model, 'wall', joint_point_on_line, bar, [1.0_wp, 0.0_wp], ground, [0.0_wp, 0.5_wp], 0.5_wp*acos(-1.0_wp))
      ! A line along y at x = 0: the bar stands upright and may not turn
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check_no_error(error, 'bar against a wall')
      call check_close(q(3), 0.0_wp, satisfied, 'the bar stands upright')
      call check(maxval(abs(v)) <= 1.0e-10_wp, 'the bar stands still: all rates are zero')

      ! Without the wall, and with a guess that the pin corrects: the speed of the guess stays
      model%joints = model%joints(:1)
      model%bodies(bar)%position = [0.1_wp, -0.2_wp]
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check_no_error(error, 'bar on a pin')
      call check_state(system, work, 0.0_wp, q, v, 'bar on a pin')
      omega = q(3)*v(4) - q(4)*v(3)
      call check_close(omega, 10.0_wp, 1.0e-11_wp, 'the bar spins as it was guessed')
      call mechanical_energy(system, work, q, v, kinetic, potential)
      call check_close(kinetic, 0.5_wp*(0.1_wp + 2.0_wp*0.25_wp)*omega**2, 1.0e-12_wp*kinetic, 'its energy is that of its spin')
      allocate (a(size(q)))
      call linearise(system, work, 0.0_wp, q, error)
      call accelerations(system, work, q, v, a)
      call check(maxval(abs(a(3:4) + omega**2*q(3:4))) <= 1.0e-10_wp*omega**2, 'u'''' is centripetal')
   end subroutine test_spin_of_guess

   !> Deflections that are given are kept to the bit, as long as frames alone can close the mechanism.
   subroutine test_deflections()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), given(:)
      integer :: culprit, n
      system = new_system(slider_crank(-0.3_wp, 0.3_wp))
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      call first_guess(system, 0.0_wp, q, v)
      n = system%layout%n(2)
      given = 1.0e-3_wp*[1.0_wp, -0.5_wp, 0.02_wp, 0.01_wp]
      call check(n == 4, 'two bending and two axial coordinates')
      q(9:12) = given
      v(9:12) = 10*given
      call assemble(system, work, 0.0_wp, q, v, error, culprit)
      call check_no_error(error, 'deflections')
      call check_state(system, work, 0.0_wp, q, v, 'deflections')
      call check(maxval(abs(q(9:12) - given)) <= 0.0_wp, 'given deflections stay')
      call check(maxval(abs(v(9:12) - 10*given)) <= 0.0_wp, 'their given rates stay')
   end subroutine test_deflections

   !> Of the two frames that satisfy the driver the one along e is meant, also where the guess is nearer to the other.
   subroutine test_driver()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp), parameter :: t = 0.7_wp
      real(wp) :: theta, rate
      integer :: bar, culprit
      model = empty_model(1.0_wp)
      theta = 0.3_wp + 2.0_wp*t + 0.5_wp*sin(3*t)
      rate = 2.0_wp + 1.5_wp*cos(3*t)
      bar = add_rigid(model, 'bar', 2.0_wp, 0.1_wp, [0.5_wp, 0.0_wp], [0.3_wp, 0.1_wp], theta + 3.0_wp)
      call join(model, 'pin', joint_revolute, bar, [0.2_wp, 0.0_wp], ground, nil)
      call add_driver(model, 'motor', bar, wavy_law(0.3_wp, 2.0_wp, 0.5_wp, 3.0_wp))
      call put_together(model, t, system, work, q, v, error, culprit)
      call check_no_error(error, 'driver')
      call check_state(system, work, t, q, v, 'driver')
      call check(maxval(abs(q(3:4) - [cos(theta), sin(theta)])) <= 1.0e-15_wp, 'the frame points where it is driven')
      call check(maxval(abs(v(3:4) - rate*[-sin(theta), cos(theta)])) <= 1.0e-14_wp, 'the frame turns as it is driven')
   end subroutine test_driver

   !> A coupler that cannot reach: the error names a joint of the loop and what is left open, 0.2 m shared by four joints.
   subroutine test_impossible()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(model_type) :: model
      real(wp), allocatable :: q(:), v(:)
      integer :: culprit
      ! The crank's pin is within 1 of the left pivot, the rocker's within 2.5 of the right one: less than 0.7 or more than
      ! 6.7 away from each other never happens
      model = four_bar([0.1_wp, -0.1_wp, 0.1_wp], 6.9_wp)
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check(allocated(error), 'a coupler that is too long cannot be assembled')
      if (allocated(error)) then
         call check(culprit >= 1 .and. culprit <= 4, 'the culprit is a joint')
         call check(index(error%message, "joint '"//model%joints(max(1, culprit))%name//"'") == 1, 'the error names it')
         call check(index(error%message, 'cannot be assembled') > 0 .and. index(error%message, 'left open at t = 0') > 0, &
            & 'the error says what is wrong and when')
      end if
      ! A rod without deflections that is shorter than the way from pin to slide
      model = empty_model(1.0_wp)
      call add_short_rod(model)
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check(allocated(error), 'a rod that is too short cannot be assembled')
      if (allocated(error)) call check_text(error%message(:index(error%message, ':')), &
         & "joint '"//model%joints(culprit)%name//"':", 'the error names the joint')
      ! Crushing or stretching a beam to twice its length is no assembly either
      call put_together(slider_crank(0.0_wp, 0.1_wp), 0.0_wp, system, work, q, v, error, culprit)
      call check(allocated(error) .and. culprit > 0, 'a beam that is too short cannot be assembled')
   end subroutine test_impossible

   !> A pin at the origin and a slide a metre above, joined by a rod of half a metre.
   subroutine add_short_rod(model)
      type(model_type), intent(inout) :: model
      integer :: rod
      rod = add_rigid(model, 'rod', 1.0_wp, 0.1_wp, [0.25_wp, 0.0_wp], [0.0_wp, 0.0_wp], 1.0_wp)
      call join(model, 'pin', joint_revolute, rod, nil, ground, nil)
      call join(model, 'slide', joint_point_on_line, rod, [0.5_wp, 0.0_wp], ground, [0.0_wp, 1.0_wp], 0.0_wp)
   end subroutine add_short_rod

   !> Consistent repetitions are no errors; they are counted, and who shares them is known: the same by singular values and by
   !> sparse factors.
   subroutine test_redundant()
      type(model_type) :: model
      ! The same pin twice: two equations of two joints
      model = four_bar([0.2_wp, 0.1_wp, -0.1_wp], 3.0_wp)
      call add_joint(model, 'twin', joint_revolute, model%joints(3)%points(2), model%joints(3)%points(1))
      call check_redundancy(model, 'twin', 8, 2, "joint 'rocker-pin' and joint 'twin'")
      ! One angle driven twice
      model = four_bar([0.0_wp, 0.0_wp, 0.0_wp], 3.0_wp)
      call add_driver(model, 'first', 1, constant_law(acos(0.5_wp)))
      call add_driver(model, 'second', 1, constant_law(acos(0.5_wp)))
      call check_redundancy(model, 'drivers', 9, 1, "driver 'first' and driver 'second'")
      ! Part of a joint: a slide through the point that a pin holds
      model = four_bar([0.0_wp, 0.0_wp, 0.0_wp], 3.0_wp)
      call add_joint(model, 'part', joint_point_on_line, model%joints(1)%points(1), model%joints(1)%points(2), 0.4_wp)
      call check_redundancy(model, 'part', 8, 1, "joint 'left' and joint 'part'")
      model = four_bar([0.0_wp, 0.0_wp, 0.0_wp], 3.0_wp)
      call check_redundancy(model, 'regular', 8, 0, '')
   end subroutine test_redundant

   !> Rank, number of redundant equations and their owners, dense and sparse; the same state from both.
   subroutine check_redundancy(model, name, rank, redundant, owners)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name, owners
      integer, intent(in) :: rank, redundant
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(assembly_type) :: found
      real(wp), allocatable :: q(:), v(:), first(:)
      integer :: culprit, round
      system = new_system(model)
      do round = 1, 2
         call new_workspace(system, work)
         allocate (q(system%layout%nq), v(system%layout%nq))
         call first_guess(system, 0.0_wp, q, v)
         call assemble(system, work, 0.0_wp, q, v, error, culprit, found, round == 1)
         call check_no_error(error, name)
         call check(found%rank == rank, name//': rank')
         call check(found%redundancy%count == redundant .and. found%singular%count == 0, name//': redundant equations')
         call check_text(constraint_names(system, found%redundancy%group > 0), owners, name//': who shares them')
         if (redundant > 0) call check(found%redundancy%excess(1) == redundant, name//': they are one group')
         call check_state(system, work, 0.0_wp, q, v, name)
         if (round == 1) allocate (first, source=q)
         call check_close(maxval(abs(q - first)), 0.0_wp, satisfied, name//': the same state')
         deallocate (q, v)
      end do
   end subroutine check_redundancy

   !> A coupler on sixty cranks, guessed roughly: 58 equations too many, all in one group; dense and sparse.
   subroutine test_many()
      integer, parameter :: cranks = 60
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(assembly_type) :: found
      real(wp), allocatable :: q(:), v(:)
      integer :: i, coupler, crank, culprit, round
      model = empty_model(1.0_wp)
      coupler = add_rigid(model, 'coupler', 5.0_wp, 1.0_wp, [0.5_wp*cranks, 0.0_wp], [0.4_wp, 0.8_wp], 0.02_wp)
      do i = 1, cranks
         crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp, nil, [real(i, wp), 0.0_wp], 1.0_wp + 0.1_wp*modulo(i, 3))
         call join(model, 'axle', joint_revolute, crank, nil, ground, [real(i, wp), 0.0_wp])
         call join(model, 'pin', joint_revolute, crank, [1.0_wp, 0.0_wp], coupler, [real(i, wp), 0.0_wp])
      end do
      do round = 1, 3
         if (round == 3) then
            ! One link fewer than that: a chain of four-bars without any redundancy
            model%joints = model%joints([1, 2, (i, i=3, size(model%joints), 2), size(model%joints)])
         end if
         system = new_system(model)
         call new_workspace(system, work)
         allocate (q(system%layout%nq), v(system%layout%nq))
         call first_guess(system, 0.0_wp, q, v)
         call assemble(system, work, 0.0_wp, q, v, error, culprit, found, round == 1)
         call check_no_error(error, 'many cranks')
         call check_close(position_residual(system, work), 0.0_wp, 4*satisfied, 'many cranks: positions')
         if (round == 3) exit
         call check(found%redundancy%count == cranks - 2 .and. found%rank == 3*cranks + 2, 'many cranks: redundant equations')
         call check(size(found%redundancy%excess) == 1 .and. all(found%redundancy%group == 1), 'many cranks: one group')
         call check(found%rates - found%rank == 1, 'many cranks: one degree of freedom')
         deallocate (q, v)
      end do
      call check(found%redundancy%count == 0, 'two cranks and many pendulums: nothing is redundant')
   end subroutine test_many

   !> Twin pins share evenly what one pin bears without them, and the motion is the same to round-off.
   subroutine test_shared_reactions()
      type(model_type) :: model
      type(system_type) :: system(2)
      type(workspace_type) :: work(2)
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:, :), v(:, :), a(:, :)
      integer :: i, culprit
      do i = 1, 2
         model = four_bar([0.0_wp, 0.0_wp, 0.0_wp], 3.0_wp)
         model%gravity = [0.3_wp, -9.81_wp]
         model%bodies(1)%spin = 2.0_wp
         if (i == 2) call add_joint(model, 'twin', joint_revolute, model%joints(3)%points(1), model%joints(3)%points(2))
         system(i) = new_system(model)
         if (i == 2) call soften_constraints(system(i))
         call new_workspace(system(i), work(i))
         if (i == 1) allocate (q(system(1)%layout%nq, 2), v(system(1)%layout%nq, 2), a(system(1)%layout%nq, 2))
         call first_guess(system(i), 0.0_wp, q(:, i), v(:, i))
         call assemble(system(i), work(i), 0.0_wp, q(:, i), v(:, i), error, culprit)
         call check_no_error(error, 'twin pins')
         call linearise(system(i), work(i), 0.0_wp, q(:, i), error)
         call check_no_error(error, 'twin pins: matrix')
         call accelerations(system(i), work(i), q(:, i), v(:, i), a(:, i))
      end do
      call check_close(maxval(abs(v(:, 2) - v(:, 1))), 0.0_wp, 1.0e-13_wp, 'twin pins: velocities')
      call check_close(maxval(abs(a(:, 2) - a(:, 1))), 0.0_wp, 1.0e-12_wp*maxval(abs(a)), 'twin pins: accelerations')
      associate (one => work(1)%lambda, two => work(2)%lambda)
         call check(norm2(one(5:6)) > 1.0_wp, 'the pin bears something')
         call check_close(norm2(two(5:6) - 0.5_wp*one(5:6)), 0.0_wp, 1.0e-7_wp*norm2(one), 'the first twin bears one half')
         call check_close(norm2(two(9:10) - 0.5_wp*one(5:6)), 0.0_wp, 1.0e-7_wp*norm2(one), 'the second twin the other half')
         call check_close(norm2(two(1:4) - one(1:4)), 0.0_wp, 1.0e-10_wp*norm2(one), 'all others what they did')
      end associate
   end subroutine test_shared_reactions

   !> Two drivers that fit in position but not in speed.
   subroutine test_dead_centre()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(model_type) :: model
      real(wp), allocatable :: q(:), v(:)
      integer :: culprit
      model = empty_model(1.0_wp)
      call add_short_rod(model)
      ! The rod reaches the line at a right angle only
      model%points(size(model%points))%p0 = [0.0_wp, 0.5_wp]
      model%bodies(1)%angle = 0.5_wp*acos(-1.0_wp)
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check(allocated(error) .and. culprit == 2, 'a mechanism at its dead centre is an error')
      if (allocated(error)) call check(index(error%message, "joint 'slide'") == 1, 'the error names the joint')
   end subroutine test_dead_centre

   !> Without constraints a guess is the state.
   subroutine test_free()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      type(model_type) :: model
      real(wp), allocatable :: q(:), v(:)
      integer :: culprit, body
      model = empty_model(1.0_wp)
      body = add_rigid(model, 'stone', 1.0_wp, 0.1_wp, [0.0_wp, 0.0_wp], [0.3_wp, 0.4_wp], 0.5_wp)
      model%bodies(body)%velocity = [1.0_wp, -2.0_wp]
      model%bodies(body)%spin = 3.0_wp
      body = add_point_mass(model, 'bead', 1.0_wp, [5.0_wp, 6.0_wp])
      call put_together(model, 0.0_wp, system, work, q, v, error, culprit)
      call check_no_error(error, 'free')
      call check(maxval(abs(q - [0.3_wp, 0.4_wp, cos(0.5_wp), sin(0.5_wp), 5.0_wp, 6.0_wp])) <= 0.0_wp, 'places of the guess')
      call check(maxval(abs(v - [1.0_wp, -2.0_wp, -3*sin(0.5_wp), 3*cos(0.5_wp), 0.0_wp, 0.0_wp])) <= 0.0_wp, 'its velocities')
   end subroutine test_free

end program test_assembly
