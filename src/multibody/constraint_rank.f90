!> Rank of the constraints at the first position. What is redundant in every position, what is so there only, and what stands still
!> although its equations let it move. Floor: multibody. Source: doc/theory, eqs. (4.29)-(4.32).
module limber_multibody_constraint_rank
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_model_model, only: ground
   use limber_multibody_assembly_newton, only: close_positions, move, change_between
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, fill, least_step, times
   use limber_multibody_equations_of_motion, only: acceleration_gaps
   use limber_multibody_kinematics, only: move_frames
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_redundant_constraints, only: redundancy_type, find_redundancy, constraint_names
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: assembly_type, check_rank, check_branch, stretch_remedy

   !> What the assembly has found
   type :: assembly_type
      !> Independent rates, constraint equations, and how many of these are independent at the first position
      integer :: rates = 0, equations = 0, rank = 0
      !> Equations that repeat others in every position, and those that do so at the first position only; allocatable, since
      !> gfortran 12 gives back the parts of the first only otherwise
      type(redundancy_type), allocatable :: redundancy, singular
      !> Largest rotation from the guess to the first position [rad], and the body that has it; 0: none has turned
      real(wp) :: turned = 0.0_wp
      integer :: body = 0
      !> Whether the frames alone could not close the joints, and deflections have
      logical :: bends = .false.
   end type assembly_type

contains

   !> Finds the rank, and whether the equations that say nothing new do so in every position. To see that, the scene is moved a
   !> little along what is left free. A scene that does not move although its equations let it is at a dead centre: an error.
   subroutine check_rank(system, work, matrix, t, q, found, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: t
      !> Assembled coordinates (nq)
      real(wp), intent(in) :: q(:)
      type(assembly_type), intent(inout) :: found
      type(error_type), allocatable, intent(out) :: error
      integer, intent(inout) :: culprit
      type(redundancy_type) :: here
      character(:), allocatable :: cause, remedy
      logical :: moved
      integer :: stuck
      call fill(system, work, matrix)
      call find_redundancy(system, matrix, here)
      found%rank = system%nc - here%count
      if (here%count == 0) then
         found%redundancy = here
         found%singular = here
         return
      end if
      matrix%truncation = matrix%nothing
      call look_aside(system, work, matrix, t, q, here, moved, stuck, found%redundancy)
      if (stuck > 0) then
         culprit = here%last(stuck)
         remedy = stretch_remedy(system, here%group == stuck)
         cause = ': the mechanism is at a dead centre: '
         if (remedy /= '') cause = ': nothing stretches between joints: '
         call raise(error, system%constraints(culprit)%item%label//cause//constraint_names(system, here%group == stuck)// &
            & ' let it move by an infinitely small way only. Remove one of them, or change a length'//remedy)
      else if (.not. moved) then
         found%redundancy = here
         allocate (found%singular%group(size(here%group)), source=0)
      else if (found%redundancy%count < here%count) then
         found%singular = here
         found%singular%count = here%count - found%redundancy%count
      else
         allocate (found%singular%group(size(here%group)), source=0)
      end if
   end subroutine check_rank

   !> What helps where constraints hold a beam or frame that does not stretch between them; nothing if they hold none.
   function stretch_remedy(system, mask) result(text)
      type(system_type), intent(in) :: system
      !> Of the constraints
      logical, intent(in) :: mask(:)
      character(:), allocatable :: text
      integer :: i, j
      text = ''
      do i = 1, size(system%constraints)
         if (.not. mask(i)) cycle
         do j = 1, 2
            if (system%constraints(i)%item%bodies(j) == ground) cycle
            associate (body => system%model%bodies(system%constraints(i)%item%bodies(j)))
               if (body%reduced%n == 0) cycle
               if (.not. body%reduced%is_exact) then
                  text = '; or let '//trim(merge('frame', 'beam ', body%is_frame))//" '"//body%name// &
                     & "' stretch, with CORRECTIONS=YES"
                  if (body%is_frame .and. body%frame_choice%accelerations) text = ''
                  if (text /= '') return
                  cycle
               end if
               if (body%reduced%exact%strains > body%reduced%exact%shears) cycle
               text = "; or let beam '"//body%name//"' stretch, with STRAIN FUNCTIONS=1"
               return
            end associate
         end do
      end do
   end function stretch_remedy

   !> Redundant equations at a position aside, where the constraints that have some have moved their bodies to.
   subroutine look_aside(system, work, matrix, t, q, here, moved, stuck, aside)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Filled at q; filled there again at the end
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: t, q(:)
      !> What is redundant at q
      type(redundancy_type), intent(in) :: here
      !> Whether something is free to move; a group of constraints that stands still although its equations let it; 0: none
      logical, intent(out) :: moved
      integer, intent(out) :: stuck
      type(redundancy_type), intent(out) :: aside
      !> How far: rotations [rad] and ways relative to the scene
      real(wp), parameter :: far = 0.02_wp, near = 0.25_wp*far
      real(wp), allocatable :: direction(:), step(:), other(:), change(:), way(:), nearer(:)
      !> Strength that constraints have there at least if they have any, relative to how far
      real(wp), parameter :: regained = 0.01_wp
      !> Parts of the way that are missing where some, and where nothing of it can be made
      real(wp), parameter :: some = 0.02_wp, most = 0.5_wp
      type(redundancy_type) :: weak
      real(wp) :: nothing
      integer :: k, owner(system%nc)
      logical :: done
      do k = 1, size(here%group)
         associate (item => system%constraints(k)%item)
            if (item%part_of > 0) cycle
            owner(item%first:item%first + item%rows - 1) = k
         end associate
      end do
      stuck = 0
      allocate (direction(matrix%columns), step(system%layout%nw), change(system%layout%nw))
      direction = 0.0_wp
      do k = 1, size(matrix%row)
         if (here%group(owner(matrix%row(k))) == 0) cycle
         direction(matrix%column(k)) = modulo(0.618034_wp*matrix%column(k), 1.0_wp) - 0.5_wp
      end do
      call keep_free()
      moved = maxval(abs(direction)) > 1.0e-4_wp
      if (.not. moved) return
      direction = direction/maxval(abs(direction))
      allocate (other(size(q)), way(matrix%columns), nearer(matrix%columns))
      call go_aside(far, way, done)
      call fill(system, work, matrix)
      call find_redundancy(system, matrix, aside)
      if (.not. done) aside%count = here%count
      stuck = stuck_group(abs(way), 0.3_wp)
      nothing = matrix%nothing
      matrix%nothing = max(nothing, regained*far)
      call find_redundancy(system, matrix, weak)
      matrix%nothing = nothing
      if (stuck == 0 .and. max(aside%count, weak%count) >= here%count) then
         call go_aside(near, nearer, done)
         if (bound_group(abs(direction - way/far), abs(direction - nearer/near), some) > 0) then
            ! Along what is missing nothing is made, if that is bound
            direction = direction - nearer/near
            call go_back()
            call keep_free()
            direction = direction/max(maxval(abs(direction)), tiny(1.0_wp))
            call go_aside(far, way, done)
            call go_aside(near, nearer, done)
            stuck = bound_group(abs(direction - way/far), abs(direction - nearer/near), most)
         end if
      end if
      call go_back()

   contains

      !> Leaves kinematics and matrix at the position itself.
      subroutine go_back()
         call place_constraints(system, work, t, q)
         call fill(system, work, matrix)
      end subroutine go_back

      !> What of the direction the equations leave free.
      subroutine keep_free()
         call least_step(matrix, times(matrix, direction)*matrix%row_scale, step)
         direction = direction - step(matrix%rate(:matrix%columns))/matrix%scale(:matrix%columns)
      end subroutine keep_free

      !> Moves the scene aside, onto the constraints.
      subroutine go_aside(distance, made, done)
         !> How far, and the way that was made, scaled (columns)
         real(wp), intent(in) :: distance
         real(wp), intent(out) :: made(:)
         logical, intent(out) :: done
         step = 0.0_wp
         step(matrix%rate(:matrix%columns)) = distance*direction*matrix%scale(:matrix%columns)
         other = q
         call move(system, step, other)
         call close_positions(system, work, matrix, t, other, done)
         call change_between(system, q, other, change)
         made = change(matrix%rate(:matrix%columns))/matrix%scale(:matrix%columns)
      end subroutine go_aside

      !> The first group that was to move and has not.
      integer function stuck_group(made, part)
         !> Way that was made (columns), and the part of the one wanted below which that is nothing
         real(wp), intent(in) :: made(:), part
         real(wp) :: wanted(size(here%excess)), moved_by(size(here%excess))
         wanted = largest_of_groups(abs(direction))
         moved_by = largest_of_groups(made)
         do stuck_group = 1, size(wanted)
            if (wanted(stuck_group) > 0.1_wp .and. moved_by(stuck_group) < part*far*wanted(stuck_group)) return
         end do
         stuck_group = 0
      end function stuck_group

      !> The first group some of whose motion is not made, however small it is, eq. (4.32).
      integer function bound_group(missing, missing_nearby, least)
         !> What is missing, relative to the distance, far and near (columns); the least of it that counts
         real(wp), intent(in) :: missing(:), missing_nearby(:), least
         real(wp), parameter :: as_much = 0.5_wp
         real(wp) :: left(size(here%excess)), left_nearby(size(here%excess))
         left = largest_of_groups(missing)
         left_nearby = largest_of_groups(missing_nearby)
         do bound_group = 1, size(left)
            if (left_nearby(bound_group) > least .and. left_nearby(bound_group) > as_much*left(bound_group)) return
         end do
         bound_group = 0
      end function bound_group

      !> The largest value in the columns of each group.
      function largest_of_groups(values) result(largest)
         real(wp), intent(in) :: values(:)
         real(wp) :: largest(size(here%excess))
         largest = 0.0_wp
         do k = 1, size(matrix%row)
            associate (group => here%group(owner(matrix%row(k))), column => matrix%column(k))
               if (group > 0) largest(group) = max(largest(group), values(column))
            end associate
         end do
      end function largest_of_groups

   end subroutine look_aside

   !> At a singular position the velocities must be those of one of the branches that meet there: else no accelerations exist.
   subroutine check_branch(system, work, matrix, q, v, found, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: q(:), v(:)
      type(assembly_type), intent(in) :: found
      type(error_type), allocatable, intent(out) :: error
      integer, intent(inout) :: culprit
      real(wp), allocatable :: step(:), left(:)
      real(wp) :: speed
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      call fill(system, work, matrix)
      allocate (step(system%layout%nw), left(system%nc))
      call acceleration_gaps(system, work)
      call least_step(matrix, work%gamma, step)
      left = times(matrix, step(matrix%rate(:matrix%columns))/matrix%scale(:matrix%columns)) - work%gamma/matrix%row_scale
      speed = maxval(abs(work%gamma/matrix%row_scale))
      if (maxval(abs(left)) <= 1.0e-6_wp*speed) return
      culprit = maxval(found%singular%last)
      call raise(error, system%constraints(culprit)%item%label//': the mechanism starts at a singular position, where branches'// &
         & ' of its motion meet, with velocities of none of them. Give SPIN=, VX=, VY= of the branch that is meant, or start'// &
         & ' elsewhere')
   end subroutine check_branch

end module limber_multibody_constraint_rank
