!> Branch of equilibria: arc length and stability. The state on it, the loads at a part of the step, one trial ahead, and the place
!> where it turns unstable. Floor: analysis. Source: doc/theory, eqs. (6.3)-(6.7), (6.15), (6.16).
module limber_analysis_static_branch
   use limber_base_kinds, only: wp
   use limber_base_signals, only: signal_came
   use limber_base_text, only: as_text, newline
   use limber_analysis_curve_path, only: curve_path_type
   use limber_scene_scene, only: scene_type
   use limber_analysis_skipped_laws, only: skips_law
   use limber_model_model, only: analysis_step_type, leave_unstable
   use limber_output_channel_values, only: recorder_type
   use limber_output_followed_turns, only: follow_places
   use limber_multibody_equilibrium, only: equilibrium_type, find_equilibrium, linearise_balance, judge, descend, is_near, extent, &
      & begin_way
   use limber_multibody_free_motions, only: motion_text
   use limber_multibody_kinematics, only: angle_type, place_frames, settle_angles
   use limber_multibody_turn_counts, only: driven_turn
   implicit none
   private
   public :: statics_type, load_scene, scale_loads, time_of, accept, try, try_start, fall_into_place, find_critical, loads_drive
   public :: tell, tell_of_leaving

   !> Increment, beside the part of the step that is done, below which it is taken where the stiffness jumps
   real(wp), parameter :: kink_part = 1.0e-6_wp
   !> Largest turn of a driven frame at once [rad]
   real(wp), parameter, public :: most_turn = 1.5_wp

   !> A static analysis under way
   type :: statics_type
      type(equilibrium_type) :: balance
      type(curve_path_type) :: paths
      type(recorder_type) :: recorder
      !> Part of the step that is done, and the state there: coordinates (nq), multipliers (nc); a trial of both
      real(wp) :: part = 0.0_wp
      real(wp), allocatable :: q(:), lambda(:), trial(:), trial_lambda(:), values(:)
      !> Angles that are followed there: a trial that is dismissed has led them astray
      type(angle_type), allocatable :: angles(:)
      !> Whether equilibrium was stable there; and whether that is known
      logical :: stable = .false., known = .false.
      !> True if the step ends before its time; and once it goes on along an equilibrium about which vibrations grow
      logical :: stopped = .false., flutters = .false.
      !> The last increment that was taken, and the change of the scene in it by its length; zero: none
      real(wp) :: increment = 0.0_wp, pace = 0.0_wp
      !> Load whose law has kept the last increments short; 0: none
      integer :: culprit = 0
      !> Weight of the deck (2), and rotation at the start of the step
      real(wp) :: gravity(2) = 0.0_wp, first_rotation = 0.0_wp
      !> What the user is told
      character(:), allocatable :: report
      !> What is told of the first sample
      character(:), allocatable :: start_text
   end type statics_type

contains

   !> Sets time-dependent loads, the part of constant ones, and the rotation, to a part of the step.
   subroutine load_scene(scene, step, part, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      if (step%ramp) then
         scene%system%model%gravity = part*statics%gravity
         call scale_loads(scene, .true., part)
      end if
      statics%balance%rotation = statics%first_rotation + part*(step%rotation - statics%first_rotation)
      statics%balance%centre = step%centre
   end subroutine load_scene

   !> Multiplies loads that are constant in time.
   subroutine scale_loads(scene, is_scaled, factor)
      type(scene_type), intent(inout) :: scene
      logical, intent(in) :: is_scaled
      real(wp), intent(in) :: factor
      integer :: i
      do i = 1, size(scene%system%loads)
         associate (load => scene%system%loads(i)%item)
            if (.not. load%grows) cycle
            load%is_scaled = is_scaled
            load%share = factor
         end associate
      end do
   end subroutine scale_loads

   pure real(wp) function time_of(step, part) result(t)
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      t = step%dynamics%start + part*(step%dynamics%end - step%dynamics%start)
      if (part >= 1.0_wp) t = step%dynamics%end
   end function time_of

   !> Equilibrium at the start of the step, if there is one: a scene that is nowhere near it is left as it is.
   subroutine try_start(scene, step, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      logical :: done
      associate (balance => statics%balance)
         call load_scene(scene, step, 0.0_wp, statics)
         statics%trial = statics%q
         statics%trial_lambda = statics%lambda
         call begin_way(balance, scene%work, statics%angles)
         call find_equilibrium(scene%system, scene%work, balance, time_of(step, 0.0_wp), statics%trial, statics%trial_lambda, &
            & .false., done)
         if (.not. done) return
         call judge(scene%system, scene%work, balance, statics%trial_lambda)
         if (.not. balance%stable) return
         statics%known = .true.
         statics%stable = .true.
         call accept(scene, statics, 0.0_wp)
      end associate
   end subroutine try_start

   !> Stable equilibrium at the start of the step, where loads act already, or else under a small part of them, where there is none
   !> without them, as of what hangs: found at once, so that it does not depend on the increments of the deck.
   subroutine fall_into_place(scene, step, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      real(wp), parameter :: first_part = 1.0e-3_wp
      if (.not. step%ramp) call fall_at(scene, step, 0.0_wp, statics)
      if (.not. statics%known) call fall_at(scene, step, first_part, statics)
      if (.not. step%dynamics%end > step%dynamics%start) return
      if (.not. statics%known) statics%start_text = newline//'      at t = '//as_text(time_of(step, 0.0_wp), 8)// &
         & ' no stable equilibrium is found: the first sample is the scene as it was, without forces of joints'
      if (statics%known .and. statics%part > 0.0_wp) statics%start_text = newline//'      at t = '// &
         & as_text(time_of(step, 0.0_wp), 8)//' no stable equilibrium is determined; the first one is that at t = '// &
         & as_text(time_of(step, first_part), 8)
   end subroutine fall_into_place

   !> Stable equilibrium at a part of the step. Where none is found the state is left as it is.
   subroutine fall_at(scene, step, part, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      real(wp) :: t
      logical :: done
      t = time_of(step, part)
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         call load_scene(scene, step, part, statics)
         statics%trial = statics%q
         statics%trial_lambda = statics%lambda
         call begin_way(balance, work, statics%angles)
         call descend(system, work, balance, t, .true., statics%trial, statics%trial_lambda, done)
         if (.not. done .or. .not. balance%stable) return
         call judge(system, work, balance, statics%trial_lambda)
         if (.not. balance%stable) return
         if (balance%has_left .and. step%instability /= leave_unstable) return
         if (balance%has_left) call tell_of_leaving(scene, statics, t)
         statics%known = .true.
         statics%stable = .true.
         call accept(scene, statics, part)
      end associate
   end subroutine fall_at

   !> Makes the trial the state.
   subroutine accept(scene, statics, part)
      type(scene_type), intent(inout) :: scene
      type(statics_type), intent(inout) :: statics
      real(wp), intent(in) :: part
      statics%q = statics%trial
      statics%lambda = statics%trial_lambda
      statics%part = part
      associate (kinematics => scene%work%kinematics)
         if (size(kinematics%angles) > 0) then
            call place_frames(scene%system%model, scene%system%layout, kinematics%time, statics%q, kinematics)
            call settle_angles(kinematics, .false.)
         end if
         call follow_places(statics%recorder%turns, scene%system, kinematics, kinematics%time, statics%q, statics%balance%turned)
         statics%balance%turned = 0.0_wp
         statics%angles(:) = kinematics%angles
      end associate
   end subroutine accept

   !> Newton's method at a part of the step from the present state, and the stability there. From an equilibrium it must stay on
   !> its branch.
   subroutine try(scene, step, part, statics, done)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      logical, intent(out) :: done
      !> Most by which the scene may soften at once
      real(wp), parameter :: softer = 1.0e3_wp
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         statics%trial = statics%q
         statics%trial_lambda = statics%lambda
         call begin_way(balance, work, statics%angles)
         ! Beyond a right angle Newton's method may find the opposite direction, which satisfies the same equation
         done = part - statics%part <= kink_part*part .or. &
            & .not. driven_turn(system, time_of(step, statics%part), time_of(step, part)) > most_turn
         if (.not. done) return
         call load_scene(scene, step, part, statics)
         call find_equilibrium(system, work, balance, time_of(step, part), statics%trial, statics%trial_lambda, statics%known, done)
         if (.not. done) return
         if (statics%known) then
            call load_scene(scene, step, statics%part, statics)
            call is_near(system, work, balance, time_of(step, statics%part), statics%trial, statics%trial_lambda, done)
            ! Where a law has a corner the tangents differ, however small the increment
            if (part - statics%part <= kink_part*part .and. statics%pace > 0.0_wp) done = done .or. &
               & extent(balance, balance%change) <= softer*statics%pace*(part - statics%part)
            call load_scene(scene, step, part, statics)
            if (.not. done) return
            if (part - statics%part > kink_part*part) then
               if (skips_law(system, work, time_of(step, statics%part), time_of(step, part), statics%q, statics%trial, &
                  & statics%culprit)) then
                  done = .false.
                  return
               end if
            end if
            call linearise_balance(system, work, balance, time_of(step, part), statics%trial, statics%trial_lambda)
         end if
         call judge(system, work, balance, statics%trial_lambda)
      end associate
   end subroutine try

   !> Whether the loads, as they grow, do work on the motion that turns unstable at the present state: then the branch ends there, a
   !> limit point; else another one crosses it. Right at the critical load the state is known to the square root of round-off only, so
   !> that this is looked at just before it.
   logical function loads_drive(scene, step, parts, q, lambda, statics) result(drive)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> A part of the step at which the state is known, its coordinates (nq) and multipliers (nc), which are scratch then; before it
      !> the part at which it is wanted
      real(wp), intent(in) :: parts(2)
      real(wp), contiguous, intent(inout) :: q(:), lambda(:)
      !> At the critical load; its motion and stability are those of the state before it then
      type(statics_type), intent(inout) :: statics
      !> Part of the loads that is taken away, and work beside that of all that is none
      real(wp), parameter :: less = 1.0e-3_wp, none = 1.0e-6_wp
      real(wp) :: change(scene%system%layout%nw), near, first_q(size(q)), first_lambda(size(lambda))
      logical :: done
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         near = parts(1)
         first_q = q
         first_lambda = lambda
         call load_scene(scene, step, near, statics)
         call find_equilibrium(system, work, balance, time_of(step, near), q, lambda, .true., done)
         if (.not. done) then
            near = parts(2)
            q = first_q
            lambda = first_lambda
            call load_scene(scene, step, near, statics)
         end if
         call linearise_balance(system, work, balance, time_of(step, near), q, lambda)
         call judge(system, work, balance, lambda)
         change = balance%motion
         call load_scene(scene, step, (1 - less)*near, statics)
         call linearise_balance(system, work, balance, time_of(step, (1 - less)*near), q, lambda)
         change = change - balance%motion
         drive = abs(dot_product(change, balance%softest)) > none*norm2(change*balance%scale)*norm2(balance%softest/balance%scale)
         call load_scene(scene, step, statics%part, statics)
         call linearise_balance(system, work, balance, time_of(step, statics%part), statics%q, statics%lambda)
      end associate
   end function loads_drive

   subroutine tell_of_leaving(scene, statics, t)
      type(scene_type), intent(in) :: scene
      type(statics_type), intent(inout) :: statics
      real(wp), intent(in) :: t
      call tell(statics, 'at t = '//as_text(t, 8)//' the loads were in balance, but not stably, as at a dead centre: '// &
         & motion_text(scene%system, statics%balance%left)//'; left for a stable equilibrium')
   end subroutine tell_of_leaving

   !> The last part of the step where equilibrium is stable, between the present state and an unstable one: it becomes the present
   !> state. Regula falsi with halved weights (Illinois) on the lowest stiffness; bisection where loads have no potential. The
   !> motion that turns unstable is left in the balance.
   subroutine find_critical(scene, step, next, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: next
      type(statics_type), intent(inout) :: statics
      integer, parameter :: most = 100
      real(wp), parameter :: critical_part = 1.0e-12_wp
      real(wp) :: left, right, of_left, of_right, middle, width, share, frequency
      real(wp), allocatable :: softest(:)
      logical :: done, flutters, by_stiffness
      integer :: round, side
      left = statics%part
      right = next
      share = 1.0_wp
      of_right = statics%balance%lowest
      call keep_unstable()
      by_stiffness = statics%balance%potential
      call try(scene, step, left, statics, done)
      if (.not. done) return
      of_left = statics%balance%lowest
      by_stiffness = by_stiffness .and. of_left > 0.0_wp .and. of_right < 0.0_wp
      side = 0
      do round = 1, most
         width = right - left
         if (width <= critical_part*right) exit
         middle = left + 0.5_wp*width
         if (by_stiffness .and. round <= 30) middle = left + width*of_left/(of_left - of_right)
         if (middle <= left .or. middle >= right) middle = left + 0.5_wp*width
         middle = left + share*(middle - left)
         call try(scene, step, middle, statics, done)
         share = min(1.0_wp, 2*share)
         if (.not. done) then
            share = 0.25_wp*share
            if (share < 1.0e-6_wp .or. signal_came()) exit
            cycle
         end if
         if (by_stiffness .and. abs(statics%balance%lowest) <= 1.0e-14_wp*statics%balance%largest) then
            call accept(scene, statics, middle)
            call keep_unstable()
            exit
         end if
         if (statics%balance%stable .or. (by_stiffness .and. statics%balance%lowest > 0.0_wp)) then
            left = middle
            of_left = statics%balance%lowest
            if (side == 1) of_right = 0.5_wp*of_right
            side = 1
            call accept(scene, statics, middle)
         else
            right = middle
            of_right = statics%balance%lowest
            if (side == -1) of_left = 0.5_wp*of_left
            side = -1
            call keep_unstable()
         end if
      end do
      call load_scene(scene, step, statics%part, statics)
      statics%balance%softest = softest
      statics%balance%flutters = flutters
      statics%balance%frequency = frequency

   contains

      subroutine keep_unstable()
         softest = statics%balance%softest
         flutters = statics%balance%flutters
         frequency = statics%balance%frequency
      end subroutine keep_unstable

   end subroutine find_critical

   !> Adds a line to what the user is told.
   pure subroutine tell(statics, text)
      type(statics_type), intent(inout) :: statics
      character(*), intent(in) :: text
      statics%report = statics%report//newline//'      '//text
   end subroutine tell

end module limber_analysis_static_branch
