!> What a run watches: velocities that change abruptly where branches of the motion meet, and only there.
program test_watch
   use limber_base_kinds, only: wp
   use limber_analysis_watch, only: jump_watch_type, start_watch, watch_velocities
   use limber_model_scene, only: ground, joint_revolute, model_type
   use limber_system_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: add_rigid, empty_model, join
   use testing, only: check, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   call check_turn(0.02_wp, .true., .true., 'a rocker that turns round near the fold')
   call check_turn(1.0_wp, .true., .false., 'one that turns round far from it')
   call check_turn(0.02_wp, .false., .false., 'one that goes on near the fold')
   call finish()

contains

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
