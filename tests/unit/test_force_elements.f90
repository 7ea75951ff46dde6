!> Force elements: every load of the deck that is more than a time law or a linear spring. Derivatives of the forces against
!> differences, power against the rate of the energy, at random states; reactions; a discrete gradient over finite steps; bad decks.
program test_force_elements
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_deck_effective, only: effective_deck
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use limber_model_build, only: build_model
   use limber_model_model, only: ground, model_type
   use limber_multibody_equations_of_motion, only: accelerations, input_power, linearise, mechanical_energy, sum_forces
   use limber_multibody_kinematics, only: move_frames, place_frames, settle_angles
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent, only: combine, new_tangent, tangent_type
   use limber_multibody_tangent_products, only: times_stiffness
   use scenes, only: derivative, random
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   real(wp), parameter :: h = 1.0e-3_wp, t = 0.3_wp

   !> Bodies of every kind, free, under every load
   character(*), parameter :: bodies = '*MATERIAL, NAME=m, YOUNG=4e5, DENSITY=90'//newline// &
      & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=0.01, INERTIA=5e-6'//newline//'*GRAVITY, X=0.4'//newline// &
      & '*GROUND'//newline//' a, 2.3, -1.6'//newline//' b, -1.4, 1.9'//newline// &
      & '*BEAM, NAME=rod, MATERIAL=m, SECTION=s, LENGTH=1.2, ELEMENTS=8, BENDING MODES=2, AXIAL MODES=1'//newline// &
      & '*BEAM, NAME=arm, MATERIAL=m, SECTION=s, LENGTH=1.2, ELEMENTS=8, BENDING MODES=2, SUPPORT=CLAMPED-FREE, ORIGIN=0.3, '// &
      & 'AXIAL MODES=3, GEOMETRIC=LINEAR'//newline// &
      & '*RIGID BODY, NAME=block, MASS=2, INERTIA=0.3, CENTRE X=0.1, CENTRE Y=-0.2'//newline//' corner, -0.4, 0.25'//newline// &
      & '*POINT MASS, NAME=bead, MASS=0.7'//newline
   !> Those that are a law of time or of the motion, or dissipate
   character(*), parameter :: driven = &
      & '*FORCE, NAME=f1, POINT=arm.end, FOLLOWER'//newline//' 1+t, -2*cos(t)'//newline// &
      & '*FORCE, NAME=f2, POINT=block.corner, FOLLOWER=YES'//newline//' x(bead)*spin(rod), 3 - 2*vy(arm.end)'//newline// &
      & '*FORCE, NAME=f3, POINT=bead'//newline//' -3*x(bead) - vx(bead) + u2(arm.end), sin(angle(block)) + u1(rod.middle)'// &
      & newline//'*FORCE, NAME=f4, POINT=rod.end'//newline//' elongation(s1)*rate(s3), y(bead)**2/(1 + elongation(r1)**2)'// &
      & newline//'*TORQUE, NAME=t1, POINT=arm.end'//newline//' 2*cos(3*t)'//newline// &
      & '*TORQUE, NAME=t2, POINT=rod.start, REACTION=block'//newline//' 1.5 - 0.3*spin(rod)'//newline// &
      & '*TORQUE, NAME=t3, BODY=arm'//newline//' -5*angle(block) - 2*spin(block) + t'//newline// &
      & '*SPRING, NAME=s3, LENGTH=0.3, DAMPING=2'//newline//' rod.end, bead, 5*x*v + t*x**2 - tanh(v)'//newline// &
      & '*SPRING, NAME=r3, TYPE=ROTATIONAL, DAMPING=0.4'//newline//' arm.start, block, sin(x)*v + exp(-x**2)'//newline// &
      & '*BUSHING, NAME=b2, DAMPING X=2, DAMPING Y=3, DAMPING ROTATION=0.7, STIFFNESS X=4, AXES=0.3'//newline// &
      & ' block.corner, arm.end'//newline//'*DISTRIBUTED LOAD, NAME=q1, BODY=arm, FOLLOWER, START=0.2'//newline// &
      & ' 1+s, sin(pi*s), 2 - t'//newline//' s - 0.7, s**2, x(bead)'//newline// &
      & '*DISTRIBUTED LOAD, NAME=q2, BODY=rod'//newline//' s - 0.6, 2'//newline// &
      & '*DAMPING, BODY=arm, RAYLEIGH ALPHA=0.3, RAYLEIGH BETA=1e-3, RATIO=0.1'//newline//' 2, 0.3'//newline// &
      & '*DAMPING, BODY=rod, RATIO=0.02'//newline
   !> Those that have an energy
   character(*), parameter :: stored = '*SPRING, NAME=s1, STIFFNESS=30, LENGTH=0.7'//newline//' rod.end, arm.end'//newline// &
      & '*SPRING, NAME=s2, LENGTH=0.7, STIFFNESS=3'//newline//' rod.middle, ground.a, 20*x + 5*x**3'//newline// &
      & '*SPRING, NAME=s4'//newline//' bead, block.corner, 3*tanh(2*x)'//newline// &
      & '*SPRING, NAME=r1, TYPE=ROTATIONAL, STIFFNESS=3, ANGLE=0.4'//newline//' arm.end, rod.middle'//newline// &
      & '*SPRING, NAME=r2, TYPE=ROTATIONAL'//newline//' ground.a, block, 2*sin(x)'//newline// &
      & '*BUSHING, NAME=b1, STIFFNESS X=10, STIFFNESS Y=20, STIFFNESS ROTATION=3, AXES=0.7, ANGLE=0.2'//newline// &
      & ' arm.end, rod.middle'//newline// &
      & '*BUSHING, NAME=b3, STIFFNESS X=10, STIFFNESS Y=20'//newline//' bead, ground.b'//newline

   call test_tangents()
   call test_power()
   call test_steps()
   call test_reactions()
   call test_complaints()
   call test_effective()
   call finish()

contains

   !> The system of a deck.
   subroutine build(text, system, work)
      character(*), intent(in) :: text
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      type(model_type) :: model
      call read_deck_text('zoo.inp', text, deck, diagnostics)
      call build_model(deck, model, diagnostics)
      call check(diagnostics%count == 0, 'the deck is good')
      if (diagnostics%count > 0) print '(a)', diagnostics%render(deck%source)
      system = new_system(model)
      call new_workspace(system, work)
   end subroutine build

   !> A random state, deflections of a tenth of the length.
   subroutine scatter(system, q, w)
      type(system_type), intent(in) :: system
      real(wp), allocatable, intent(out) :: q(:), w(:)
      integer :: i, k, first
      real(wp) :: angle
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
   end subroutine scatter

   !> Residual of the motion with one coordinate and rate moved.
   subroutine residual_at(system, work, q, w, a, index, dx, dw, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:), a(:)
      integer, intent(in) :: index
      real(wp), intent(in) :: dx, dw
      real(wp), intent(inout) :: motion(:)
      real(wp) :: change(size(w)), rate(size(w)), moved(size(q)), v(size(q)), none(0), empty(0)
      change = 0.0_wp
      change(index) = dx
      rate = w
      rate(index) = rate(index) + dw
      call advance(system%layout, q, change, moved)
      call velocities_of(system%layout, moved, rate, v)
      call motion_residual(system, work, t, moved, v, a, none, motion, empty)
   end subroutine residual_at

   !> Stiffness and damping of all loads, beams and bodies together, column by column.
   subroutine test_tangents()
      type(system_type) :: system
      type(workspace_type) :: work
      type(tangent_type) :: tangent
      real(wp), allocatable :: q(:), w(:), a(:), v(:), motion(:, :), unit(:), column(:), difference(:)
      real(wp) :: none(0), largest
      integer :: j, k, n, trial
      call build(bodies//driven//stored, system, work)
      call check(size(system%loads) == 50, 'all loads are there, each follower along the arm at five stations')
      call new_tangent(system, tangent)
      n = system%layout%nw
      allocate (a(n), v(system%layout%nq), motion(n, -2:2), unit(n), column(n), difference(n))
      do trial = 1, 3
         call scatter(system, q, w)
         a = 0.0_wp
         call residual_at(system, work, q, w, a, 1, 0.0_wp, 0.0_wp, motion(:, 0))
         call velocities_of(system%layout, q, w, v)
         call linearise_motion(system, work, tangent, q, v, a, none)
         largest = maxval(abs(tangent%parts(:, 3)))
         do j = 1, n
            do k = -2, 2
               call residual_at(system, work, q, w, a, j, k*h, 0.0_wp, motion(:, k))
            end do
            difference = derivative(motion(:, -2), motion(:, -1), motion(:, 1), motion(:, 2), h)
            unit = 0.0_wp
            unit(j) = 1.0_wp
            column = 0.0_wp
            call times_stiffness(system, tangent, 1.0_wp, unit, column)
            call check(maxval(abs(column - difference)) <= 1.0e-8_wp*largest, 'stiffness of force elements')
            do k = -2, 2
               call residual_at(system, work, q, w, a, j, 0.0_wp, k*h, motion(:, k))
            end do
            difference = derivative(motion(:, -2), motion(:, -1), motion(:, 1), motion(:, 2), h)
            call combine(tangent, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp)
            column = matmul(dense(tangent, n), unit)
            call check(maxval(abs(column - difference)) <= 1.0e-9_wp*largest, 'damping of force elements')
         end do
         deallocate (q, w)
      end do
   end subroutine test_tangents

   !> The matrix of a tangent, entry by entry (n, n).
   function dense(tangent, n) result(matrix)
      type(tangent_type), intent(in) :: tangent
      integer, intent(in) :: n
      real(wp) :: matrix(n, n)
      integer :: i, j, place
      matrix = 0.0_wp
      do j = 1, n
         do i = 1, n
            place = tangent%matrix%place(i, j)
            if (place > 0) matrix(i, j) = tangent%matrix%values(place)
         end do
      end do
   end function dense

   !> The power put in is the rate of the energy along q + v t + a t^2/2.
   subroutine test_power()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), w(:), v(:), a(:)
      real(wp), parameter :: step = 3.0e-6_wp
      real(wp) :: energy(-2:2), kinetic, potential, power, scale
      integer :: k, trial
      do trial = 1, 4
         if (trial <= 2) call build(bodies//driven//stored, system, work)
         if (trial > 2) call build(bodies//stored, system, work)
         call scatter(system, q, w)
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
         if (trial <= 2) call check(abs(power) > 1.0e-2_wp, 'there is power')
         deallocate (q, w, v, a)
      end do
   end subroutine test_power

   !> Over a step of any length what a load with an energy gives to the motion of the mean is what its energy loses.
   subroutine test_steps()
      type(system_type) :: system
      type(workspace_type) :: work, mean
      real(wp), allocatable :: q(:), w(:), force(:)
      real(wp), parameter :: span = 0.7_wp
      real(wp) :: before, after, work_done, power
      integer :: i, k, first, trial
      call build(bodies//stored, system, work)
      call new_workspace(system, mean)
      do trial = 1, 5
         call scatter(system, q, w)
         do i = 1, size(system%loads)
            call end_points(system, q, w, span, work, mean, before, after, i)
            associate (load => system%loads(i)%item)
               allocate (force(sum(load%rates)))
               force = 0.0_wp
               call load%add_force(mean%kinematics, force)
               work_done = 0.0_wp
               do k = 1, size(load%bodies)
                  if (load%bodies(k) == ground) cycle
                  first = system%layout%w(load%bodies(k))
                  work_done = work_done + span*dot_product(force(load%offsets(k) + 1:load%offsets(k) + load%rates(k)), &
                     & w(first:first + load%rates(k) - 1))
               end do
               call check_close(work_done, before - after, 1.0e-12_wp*(1 + abs(before) + abs(after)), &
                  & 'work of a load over a step')
               power = 0.0_wp
               call load%add_power(mean%kinematics, power)
               call check_close(power, 0.0_wp, 0.0_wp, 'nothing is put in')
               deallocate (force)
            end associate
         end do
         deallocate (q, w)
      end do
   end subroutine test_steps

   !> Energies of a load at both ends of a step with the mean rates w, and the kinematics of the mean: eqs. (5.21), (5.25).
   subroutine end_points(system, q, w, span, work, mean, before, after, index)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:), w(:), span
      type(workspace_type), intent(inout) :: work, mean
      real(wp), intent(out) :: before, after
      integer, intent(in) :: index
      real(wp) :: change(size(w)), final(size(q)), alpha
      integer :: i, k, m, at
      change = span*w
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         if (system%layout%framed(i)) change(at + 2) = 2*atan(0.5_wp*span*w(at + 2))
      end do
      call advance(system%layout, q, change, final)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call settle_angles(work%kinematics, .false.)
      before = 0.0_wp
      call system%loads(index)%item%add_energy(work%kinematics, before)
      mean%kinematics = work%kinematics
      call place_frames(system%model, system%layout, t, final, work%kinematics)
      after = 0.0_wp
      call system%loads(index)%item%add_energy(work%kinematics, after)
      mean%kinematics%span = span
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         associate (frame => mean%kinematics%frames(i))
            frame%u = 0.5_wp*(frame%u + work%kinematics%frames(i)%u)
            frame%velocity = w(at:at + 1)
            if (system%layout%framed(i)) frame%omega = w(at + 2)
         end associate
      end do
      do m = 1, size(mean%kinematics%markers)
         associate (marker => mean%kinematics%markers(m), b => work%kinematics%markers(m))
            if (marker%body == ground) cycle
            alpha = 0.0_wp
            if (system%layout%framed(marker%body)) alpha = span*w(system%layout%w(marker%body) + 2)
            marker%velocity = (b%position - marker%position)/span
            marker%position = 0.5_wp*(marker%position + b%position)
            marker%lever = 0.5_wp*(marker%lever + b%lever)
            do k = 1, size(marker%shape, 2)
               marker%shape(:, k) = 0.5_wp*(1 + 0.25_wp*alpha**2)*(marker%shape(:, k) + b%shape(:, k))
            end do
         end associate
      end do
      do m = 1, size(mean%kinematics%angles)
         mean%kinematics%angles(m)%value = 0.5_wp*(mean%kinematics%angles(m)%value + work%kinematics%angles(m)%value)
      end do
   end subroutine end_points

   !> What acts between two bodies makes no force and no moment in all.
   subroutine test_reactions()
      type(system_type) :: system
      type(workspace_type) :: work
      real(wp), allocatable :: q(:), w(:), v(:), force(:)
      real(wp) :: total(2), moment, largest
      integer :: i, k, first
      call build(bodies//driven//stored, system, work)
      call scatter(system, q, w)
      allocate (v(size(q)))
      call velocities_of(system%layout, q, w, v)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item)
            if (.not. acts_within(system, i)) cycle
            allocate (force(sum(load%rates)))
            force = 0.0_wp
            call load%add_force(work%kinematics, force)
            total = 0.0_wp
            moment = 0.0_wp
            largest = maxval(abs(force))
            do k = 1, size(load%bodies)
               first = load%offsets(k)
               total = total + force(first + 1:first + 2)
               associate (frame => work%kinematics%frames(load%bodies(k)))
                  moment = moment + frame%position(1)*force(first + 2) - frame%position(2)*force(first + 1)
               end associate
               if (load%rates(k) > 2) moment = moment + force(first + 3)
            end do
            call check_close(maxval(abs(total)), 0.0_wp, 1.0e-13_wp*(1 + largest), 'no force in all')
            call check_close(moment, 0.0_wp, 1.0e-13_wp*(1 + largest), 'no moment in all')
            deallocate (force)
         end associate
      end do
   end subroutine test_reactions

   !> Whether a load is one of the springs and bushings between two bodies.
   logical function acts_within(system, index)
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      integer :: i
      acts_within = .false.
      do i = 1, size(system%model%loads)
         associate (named => system%model%loads(i))
            if (named%first > index .or. named%last < index) cycle
            acts_within = any([character(2) :: 's4', 'r1', 'b1', 'b2', 's3', 'r3', 't2'] == named%name)
         end associate
      end do
   end function acts_within

   !> What is wrong is said where it stands.
   subroutine test_complaints()
      call complains('*FORCE, NAME=f, POINT=bead'//newline//' ax(bead), 0', "a load cannot depend on 'ax'")
      call complains('*FORCE, NAME=f, POINT=bead'//newline//' x(beat), 0', "there is no point 'beat'")
      call complains('*FORCE, NAME=f, POINT=bead'//newline//' v, 0', "there is no parameter 'v'")
      call complains('*FORCE, NAME=f, POINT=bead, FOLLOWER'//newline//' 1, 0', "'bead' is a point mass and does not turn")
      call complains('*TORQUE, NAME=f'//newline//' 1', "torque 'f' needs BODY or POINT, one of them")
      call complains('*TORQUE, NAME=f, POINT=bead'//newline//' 1', "'bead' is a point mass and does not turn")
      call complains('*SPRING, NAME=f'//newline//' bead, block', "spring 'f' does nothing")
      call complains('*SPRING, NAME=f, TYPE=ROTATIONAL, LENGTH=2'//newline//' arm.end, block, x', &
         & 'LENGTH means nothing with TYPE=ROTATIONAL')
      call complains('*SPRING, NAME=f, ANGLE=2'//newline//' arm.end, block, x', 'ANGLE means nothing with TYPE=TRANSLATIONAL')
      call complains('*SPRING, NAME=f, TYPE=ROTATIONAL'//newline//' block.corner, block, x', &
         & "spring 'f' turns a body against itself")
      call complains('*SPRING, NAME=f'//newline//' bead, block, x, v', 'a data line of *SPRING has 2 to 3 fields')
      call complains('*BUSHING, NAME=f, STIFFNESS X=1'//newline//' block.corner, block', "bushing 'f' joins a body to itself")
      call complains('*DISTRIBUTED LOAD, NAME=f, BODY=arm, END=2'//newline//' 1, 0', "load 'f' acts from 0 to 2")
      call complains('*DISTRIBUTED LOAD, NAME=f, BODY=arm'//newline//' t, 0', 'the time t has no meaning here')
      call complains('*DAMPING, BODY=arm'//newline//' 7, 0.1', "beam 'arm' has 5 modes, 2 of them bending")
      call complains('*DAMPING, BODY=arm'//newline//'*DAMPING, BODY=arm', "beam 'arm' is damped twice")
      call complains('*JOINT, NAME=w, TYPE=WELD'//newline//' block, ground.a'//newline// &
         & '*FRICTION, NAME=f, JOINT=w, COEFFICIENT=1', "there is no friction in joint 'w'")
      call complains('*FRICTION, NAME=f, JOINT=nowhere, COEFFICIENT=1', "there is no *JOINT named 'nowhere'")
   end subroutine test_complaints

   !> The effective deck, defaults and all, is a deck of the same loads.
   subroutine test_effective()
      type(deck_type) :: deck, again
      type(diagnostics_type) :: diagnostics
      type(model_type) :: model, same
      call read_deck_text('zoo.inp', bodies//driven//stored, deck, diagnostics)
      call build_model(deck, model, diagnostics)
      call read_deck_text('effective.inp', effective_deck(deck), again, diagnostics)
      call build_model(again, same, diagnostics)
      call check(diagnostics%count == 0, 'the effective deck is good')
      if (diagnostics%count > 0) print '(a)', diagnostics%render(again%source)
      call check(size(same%load_parts) == size(model%load_parts) .and. size(same%loads) == size(model%loads), 'all loads again')
      call check(all(abs(same%load_parts%factor - model%load_parts%factor) <= 1.0e-15_wp*abs(model%load_parts%factor)), &
         & 'same loads')
   end subroutine test_effective

   subroutine complains(lines, message)
      character(*), intent(in) :: lines, message
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      type(model_type) :: model
      call read_deck_text('bad.inp', bodies//lines, deck, diagnostics)
      if (diagnostics%count == 0) call build_model(deck, model, diagnostics)
      call check(diagnostics%count > 0, 'complains: '//message)
      if (diagnostics%count == 0) return
      call check(index(diagnostics%render(deck%source), message) > 0, message)
      if (index(diagnostics%render(deck%source), message) == 0) print '(a)', diagnostics%render(deck%source)
   end subroutine complains

end program test_force_elements
