!> What a run watches: velocities that change abruptly where branches of the motion meet, and only there.
program test_watch
   use limber_base_kinds, only: wp
   use limber_monitor_run_monitor, only: jump_watch_type, start_watch, watch_velocities
   use limber_base_error, only: error_type
   use limber_integrator_fold_crossing, only: crossing_type, find_weakest, new_crossing
   use limber_model_model, only: ground, model_type
   use limber_multibody_equations_of_motion, only: linearise
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, add_driver, add_rigid, constant_law, empty_model, join
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   call check_turn(0.02_wp, .true., .true., 'a rocker that turns round near the fold')
   call check_turn(1.0_wp, .true., .false., 'one that turns round far from it')
   call check_turn(0.02_wp, .false., .false., 'one that goes on near the fold')
   call check_close(strength_in(1.0e3_wp), strength_in(1.0_wp), 1.0e-9_wp*strength_in(1.0_wp), 'strength in millimetres')
   call check_close(strength_in(1.0e-3_wp), strength_in(1.0_wp), 1.0e-9_wp*strength_in(1.0_wp), 'strength in kilometres')
   call finish()

contains

   !> How much the weakest combination of constraints of a driven four-bar binds, with lengths in another unit. The driver's row is
   !> an angle.
   real(wp) function strength_in(unit) result(strength)
      !> Units in a metre
      real(wp), intent(in) :: unit
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(crossing_type) :: scratch
      type(error_type), allocatable :: error
      integer :: crank, rocker, coupler
      strength = 0.0_wp
      model = empty_model(2.0_wp*unit)
      crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp*unit**2, [0.5_wp*unit, 0.0_wp], nil, 0.5_wp)
      rocker = add_rigid(model, 'rocker', 1.0_wp, 0.1_wp*unit**2, [0.5_wp*unit, 0.0_wp], [2.0_wp*unit, 0.0_wp], 0.5_wp)
      coupler = add_rigid(model, 'coupler', 1.0_wp, 0.3_wp*unit**2, [unit, 0.0_wp], unit*[cos(0.5_wp), sin(0.5_wp)], 0.0_wp)
      call join(model, 'left', joint_revolute, crank, nil, ground, nil)
      call join(model, 'right', joint_revolute, rocker, nil, ground, [2.0_wp*unit, 0.0_wp])
      call join(model, 'crank-pin', joint_revolute, coupler, nil, crank, [unit, 0.0_wp])
      call join(model, 'rocker-pin', joint_revolute, coupler, [2.0_wp*unit, 0.0_wp], rocker, [unit, 0.0_wp])
      call add_driver(model, 'motor', crank, constant_law(0.5_wp))
      system = new_system(model)
      call new_workspace(system, work)
      call linearise(system, work, 0.0_wp, [0.0_wp, 0.0_wp, cos(0.5_wp), sin(0.5_wp), 2.0_wp*unit, 0.0_wp, cos(0.5_wp), &
         & sin(0.5_wp), unit*cos(0.5_wp), unit*sin(0.5_wp), 1.0_wp, 0.0_wp], error)
      call check_no_error(error, 'four-bar')
      call new_crossing(system, scratch)
      call find_weakest(scratch, system, work, strength)
      call check(strength > 1.0e-6_wp .and. strength < 1.0e6_wp, 'four-bar: something binds')
   end function strength_in

   !> A parallelogram that turns at 1 rad/s; then its rocker turns the other way, or not.
   subroutine check_turn(angle, jumps, told, name)
      !> Angle of the cranks behind the fold, where it happens
      real(wp), intent(in) :: angle
      !> Whether velocities jump, and whether that is to be told
      logical, intent(in) :: jumps, told
      character(*), intent(in) :: name
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(jump_watch_type) :: watch
      character(:), allocatable :: text
      real(wp), allocatable :: q(:), v(:)
      integer :: i, crank, rocker, coupler
      model = empty_model(2.0_wp)
      crank = add_rigid(model, 'crank', 1.0_wp, 0.1_wp, [0.5_wp, 0.0_wp], nil, angle)
      rocker = add_rigid(model, 'rocker', 1.0_wp, 0.1_wp, [0.5_wp, 0.0_wp], [2.0_wp, 0.0_wp], angle)
      coupler = add_rigid(model, 'coupler', 1.0_wp, 0.3_wp, [1.0_wp, 0.0_wp], [cos(angle), sin(angle)], 0.0_wp)
      call join(model, 'left', joint_revolute, crank, nil, ground, nil)
      call join(model, 'right', joint_revolute, rocker, nil, ground, [2.0_wp, 0.0_wp])
      call join(model, 'crank-pin', joint_revolute, coupler, nil, crank, [1.0_wp, 0.0_wp])
      call join(model, 'rocker-pin', joint_revolute, coupler, [2.0_wp, 0.0_wp], rocker, [1.0_wp, 0.0_wp])
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      do i = 0, 40
         call place(angle - 0.01_wp*(40 - i), 1.0_wp, q, v)
         if (i == 0) call start_watch(watch, 0.0_wp, v)
         call watch_velocities(watch, system, work, 0.01_wp*i, q, v, text)
         call check(.not. allocated(text), name//': nothing is told before')
      end do
      call place(angle + 0.001_wp, merge(-1.0_wp, 1.0_wp, jumps), q, v)
      call watch_velocities(watch, system, work, 0.401_wp, q, v, text)
      call check(allocated(text) .eqv. told, name)
      if (allocated(text)) call check(index(text, "body 'rocker' change abruptly at t = 0.401") > 0 .and. &
         & index(text, "joint 'rocker-pin'") > 0, name//': '//text)
      if (allocated(text)) deallocate (text)
   end subroutine check_turn

   !> State of the parallelogram; the rocker's spin is given.
   subroutine place(angle, spin, q, v)
      real(wp), intent(in) :: angle, spin
      real(wp), intent(out) :: q(:), v(:)
      associate (c => cos(angle), s => sin(angle))
         q = [0.0_wp, 0.0_wp, c, s, 2.0_wp, 0.0_wp, c, s, c, s, 1.0_wp, 0.0_wp]
         v = [0.0_wp, 0.0_wp, -s, c, 0.0_wp, 0.0_wp, -spin*s, spin*c, -s, c, 0.0_wp, 0.0_wp]
      end associate
   end subroutine place

end program test_watch
