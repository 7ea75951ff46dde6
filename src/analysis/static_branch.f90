!> Branch of equilibria: arc length and stability. The state on it, the loads at a part of the step, one trial ahead, and the place
!> where it turns unstable. Floor: analysis. Source: doc/theory, eqs. (6.3)-(6.7), (6.15), (6.16).
module limber_analysis_static_branch
   use limber_base_kinds, only: wp
   use limber_base_signals, only: signal_came
   use limber_base_text, only: as_text, newline
   use limber_analysis_curve_path, only: curve_path_type
   use limber_analysis_flutter_aside, only: flutter_aside_type, check_flutter
   use limber_scene_scene, only: scene_type
   use limber_analysis_skipped_laws, only: skips_law
   use limber_model_model, only: analysis_step_type, leave_unstable, stop_unstable
   use limber_output_channel_values, only: recorder_type
   use limber_output_followed_turns, only: follow_places
   use limber_multibody_equilibrium, only: equilibrium_type, find_equilibrium, linearise_balance, is_near, extent, &
      & first_step, settle_beside, begin_way
   use limber_multibody_free_motions, only: motion_text
   use limber_multibody_kinematics, only: angle_type, place_frames, settle_angles
   use limber_multibody_stability, only: judge, descend
   use limber_multibody_turn_counts, only: driven_turn
   implicit none
   private
   public :: statics_type, load_scene, scale_loads, time_of, accept, try, try_start, fall_into_place, find_critical, loads_drive
   public :: tell, tell_of_leaving, tell_unstable, stay_on, stand, place_text, flutter_text, judge_branch

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
      !> Parts of the step that no increment passes, in ascending order; the part of the last sample
      real(wp), allocatable :: stations(:)
      real(wp) :: sampled = -1.0_wp
      !> Part of the step of the last critical load, between the states on both sides; below zero where it is that of the state. How
      !> much stiffness the loads take there, all of them as they do just before it; zero: not known
      real(wp) :: critical = -1.0_wp, taken = 0.0_wp
      !> Weight of the deck (2), and rotation at the start of the step
      real(wp) :: gravity(2) = 0.0_wp, first_rotation = 0.0_wp
      !> What the user is told
      character(:), allocatable :: report
      !> Vibrations that grow and do not count
      type(flutter_aside_type) :: flutter
      !> What is told of the first sample; and of a neutral equilibrium, unless the next one is unstable
      character(:), allocatable :: start_text, neutral_text
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
         call judge_branch(scene, statics, time_of(step, 0.0_wp), statics%trial, statics%trial_lambda)
         if (balance%stable) then
            statics%known = .true.
            statics%stable = .true.
            call accept(scene, statics, 0.0_wp)
         else
            call start_unstable(scene, step, 0.0_wp, statics)
         end if
      end associate
   end subroutine try_start

   !> Takes the trial, an unstable equilibrium, as the first one: where it is to be kept, and the deck places the scene there; or
   !> where vibrations grow, for then there is no other.
   subroutine start_unstable(scene, step, part, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      !> Part of the scales within which a place is that of the deck
      real(wp), parameter :: placed = 1.0e-2_wp
      associate (balance => statics%balance)
         if (balance%stable .or. balance%neutral) return
         if (extent(balance, balance%change) > placed) return
         if (step%instability == leave_unstable .and. .not. balance%flutters) return
         statics%known = .true.
         statics%stable = .false.
         statics%flutters = balance%flutters
         statics%stopped = step%instability == stop_unstable
         call accept(scene, statics, part)
         call tell_unstable(scene, step, statics)
      end associate
   end subroutine start_unstable

   !> Tells that the present state is an unstable equilibrium.
   subroutine tell_unstable(scene, step, statics)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      character(:), allocatable :: kind
      kind = ''
      if (statics%balance%flutters) kind = ' ('//flutter_text(scene, statics)//')'
      call tell(statics, 'equilibrium is unstable at '//place_text(step, statics%part)//kind//': '// &
         & motion_text(scene%system, statics%balance%softest))
   end subroutine tell_unstable

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
         & as_text(time_of(step, 0.0_wp), 8)//trim(merge(' no stable', ' no       ', statics%stable))// &
         & ' equilibrium is determined; the first one is that at t = '//as_text(time_of(step, first_part), 8)
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
         if (step%instability /= leave_unstable) then
            call find_equilibrium(system, work, balance, t, statics%trial, statics%trial_lambda, .false., done)
            if (done) call judge_branch(scene, statics, t, statics%trial, statics%trial_lambda)
            if (done) call start_unstable(scene, step, part, statics)
            if (statics%known) return
            statics%trial = statics%q
            statics%trial_lambda = statics%lambda
            call begin_way(balance, work, statics%angles)
         end if
         call descend(system, work, balance, t, .true., statics%trial, statics%trial_lambda, done)
         if (.not. done .or. .not. balance%stable) return
         call judge_branch(scene, statics, t, statics%trial, statics%trial_lambda)
         if (.not. balance%stable) return
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
   !> its branch. A trial that fails leaves no turns behind.
   subroutine try(scene, step, part, statics, done)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      logical, intent(out) :: done
      type(angle_type), allocatable :: angles(:)
      allocate (angles, source=scene%work%kinematics%angles)
      call try_near(scene, step, part, statics, done)
      if (.not. done) scene%work%kinematics%angles = angles
   end subroutine try

   !> The trial.
   subroutine try_near(scene, step, part, statics, done)
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
         call judge_branch(scene, statics, time_of(step, part), statics%trial, statics%trial_lambda)
      end associate
   end subroutine try_near

   !> Goes on along a branch that is unstable, at an equilibrium that was found on it.
   subroutine stay_on(scene, step, part, q, lambda, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Part of the step of that equilibrium; its coordinates (nq) and multipliers (nc)
      real(wp), intent(in) :: part, q(:), lambda(:)
      type(statics_type), intent(inout) :: statics
      statics%trial = q
      statics%trial_lambda = lambda
      call load_scene(scene, step, part, statics)
      call linearise_balance(scene%system, scene%work, statics%balance, time_of(step, part), q, lambda)
      call judge_branch(scene, statics, time_of(step, part), q, lambda)
      statics%known = .true.
      statics%stable = .false.
      call accept(scene, statics, part)
   end subroutine stay_on

   !> What serves where Newton's method does not find an equilibrium a little farther on: the present state, if what it lacks is
   !> round-off; or one at the end of the increment, if that is a critical load, where the tangent is singular, and the loads do no
   !> work on what turns unstable. It is the trial then, and its stability is known.
   subroutine stand(scene, step, next, target, statics, done)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Part of the step that was tried, and the end of the increment
      real(wp), intent(in) :: next, target
      type(statics_type), intent(inout) :: statics
      logical, intent(out) :: done
      !> Stiffness beside the forces that is none so near to a critical load; change of a coordinate that is round-off
      real(wp), parameter :: none = 1.0e-6_wp, round_off = 1.0e-8_wp
      real(wp), allocatable :: q(:), lambda(:)
      real(wp) :: size_of
      done = .false.
      if (.not. statics%known) return
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         statics%trial = statics%q
         statics%trial_lambda = statics%lambda
         call load_scene(scene, step, next, statics)
         call linearise_balance(system, work, balance, time_of(step, next), statics%q, statics%lambda)
         call first_step(system, work, balance, size_of)
         call judge(system, work, balance, statics%lambda)
         balance%change = 0.0_wp
         done = size_of <= round_off .and. balance%stable
         if (done .or. next < target) return
         if (.not. (statics%stable .or. step%instability /= leave_unstable)) return
         if (abs(balance%lowest) > none*max(balance%largest, balance%forces)) return
         call settle_beside(system, work, balance, time_of(step, next), statics%trial, statics%trial_lambda, done)
         if (.not. done) return
         allocate (q, source=statics%q)
         allocate (lambda, source=statics%lambda)
         done = .not. loads_drive(scene, step, [0.99_wp, 1.0_wp]*statics%part, q, lambda, statics)
         call load_scene(scene, step, next, statics)
         call linearise_balance(system, work, balance, time_of(step, next), statics%trial, statics%trial_lambda)
         call judge(system, work, balance, statics%trial_lambda)
         balance%neutral = .true.
         balance%stable = .false.
      end associate
   end subroutine stand

   !> Whether the loads, as they grow, do work on the motion that turns unstable at the present state: then the branch ends there, a
   !> limit point; else another one crosses it. Right at the critical load the state is known to the square root of round-off only,
   !> so that this is looked at just before it.
   logical function loads_drive(scene, step, parts, q, lambda, statics) result(drive)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> A part of the step at which the state is known, its coordinates (nq) and multipliers (nc), which are scratch then; before
      !> it the part at which it is wanted
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

   !> Stability of a place that was linearised. Vibrations that grow are confirmed by more coordinates.
   subroutine judge_branch(scene, statics, t, q, lambda)
      type(scene_type), intent(inout) :: scene
      type(statics_type), intent(inout) :: statics
      !> Time, coordinates (nq), multipliers (nc)
      real(wp), intent(in) :: t, q(:), lambda(:)
      call judge(scene%system, scene%work, statics%balance, lambda)
      if (statics%balance%flutters) call check_flutter(statics%flutter, scene, statics%balance, t, q, lambda)
   end subroutine judge_branch

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
      !> Step aside beside the width; widths beside the part of the step where round-off may keep Newton's method from more, and
      !> where the stiffness is straight between both ends
      real(wp), parameter :: aside = 1.0e-6_wp, near_part = 1.0e-8_wp, near_root = 1.0e-5_wp
      !> Parts of the step, and lowest stiffness there
      real(wp) :: ends(2), lowest(2), first
      !> Part of the first stiffness with which round-off moves nothing, and the last state with it; the same of the slope of the
      !> stiffness, and the last part of the step with it and its stiffness
      real(wp), parameter :: clear = 1.0e-5_wp, steep = 0.3_wp
      real(wp) :: before(2)
      real(wp), allocatable :: clear_q(:), clear_lambda(:)
      integer :: round, side
      left = statics%part
      right = next
      statics%critical = -1.0_wp
      statics%taken = 0.0_wp
      share = 1.0_wp
      of_right = statics%balance%lowest
      call keep_unstable()
      by_stiffness = statics%balance%potential
      call try(scene, step, left, statics, done)
      if (.not. done) return
      of_left = statics%balance%lowest
      by_stiffness = by_stiffness .and. of_left > 0.0_wp .and. of_right < 0.0_wp
      ends = [left, right]
      lowest = [of_left, of_right]
      first = of_left
      before = [left, of_left]
      allocate (clear_q, source=statics%q)
      allocate (clear_lambda, source=statics%lambda)
      side = 0
      do round = 1, most
         width = right - left
         if (width <= critical_part*right) exit
         middle = left + 0.5_wp*width
         if (by_stiffness .and. round <= 30) middle = left + width*of_left/(of_left - of_right)
         if (middle <= left .or. middle >= right) middle = left + 0.5_wp*width
         middle = left + share*(middle - left)
         call try(scene, step, middle, statics, done)
         if (.not. done .and. by_stiffness) then
            ! The tangent is singular at the very critical load: it is approached from both sides
            middle = min(max(middle + merge(-aside, aside, side == -1)*width, left + 0.25_wp*aside*width), &
               & right - 0.25_wp*aside*width)
            call try(scene, step, middle, statics, done)
         end if
         share = min(1.0_wp, 2*share)
         if (.not. done) then
            share = 0.25_wp*share
            if (share < 1.0e-6_wp .or. signal_came() .or. width <= near_part*right) exit
            cycle
         end if
         if (by_stiffness .and. abs(statics%balance%lowest) <= 1.0e-14_wp*statics%balance%largest) then
            call accept(scene, statics, middle)
            call keep_unstable()
            statics%critical = middle
            exit
         end if
         if (statics%balance%stable .or. (by_stiffness .and. statics%balance%lowest > 0.0_wp)) then
            left = middle
            of_left = statics%balance%lowest
            ends(1) = left
            lowest(1) = of_left
            if (of_left > steep*first) before = [left, of_left]
            if (of_left > clear*first) then
               clear_q = statics%trial
               clear_lambda = statics%trial_lambda
            end if
            if (side == 1) of_right = 0.5_wp*of_right
            side = 1
            call accept(scene, statics, middle)
         else
            right = middle
            of_right = statics%balance%lowest
            ends(2) = right
            lowest(2) = of_right
            if (side == -1) of_left = 0.5_wp*of_left
            side = -1
            call keep_unstable()
         end if
      end do
      if (by_stiffness .and. right - left <= near_root*right) statics%critical = ends(1) + (ends(2) - ends(1)) &
         & *lowest(1)/(lowest(1) - lowest(2))
      if (statics%critical > before(1)) statics%taken = before(2)*statics%critical/(statics%critical - before(1))
      if (statics%critical >= 0.0_wp) call approach(statics%critical)
      call load_scene(scene, step, statics%part, statics)
      statics%balance%softest = softest
      statics%balance%flutters = flutters
      statics%balance%frequency = frequency

   contains

      !> Takes the very critical load, where round-off moves what Newton's method finds: a spring holds what turns unstable.
      subroutine approach(part)
         real(wp), intent(in) :: part
         real(wp), parameter :: near = 1.0e-3_wp
         logical :: settled
         statics%trial = clear_q
         statics%trial_lambda = clear_lambda
         call load_scene(scene, step, part, statics)
         call settle_beside(scene%system, scene%work, statics%balance, time_of(step, part), statics%trial, statics%trial_lambda, &
            & settled)
         if (settled .and. extent(statics%balance, statics%balance%change) <= near) call accept(scene, statics, part)
      end subroutine approach

      subroutine keep_unstable()
         softest = statics%balance%softest
         flutters = statics%balance%flutters
         frequency = statics%balance%frequency
      end subroutine keep_unstable

   end subroutine find_critical

   function flutter_text(scene, statics) result(text)
      type(scene_type), intent(in) :: scene
      type(statics_type), intent(in) :: statics
      character(:), allocatable :: text
      text = 'flutter: vibrations at '//as_text(statics%balance%frequency, 5)//' rad/'//scene%system%model%units%time// &
         & ' grow; *DYNAMICS shows where they lead'
   end function flutter_text

   !> An instant, and the part of the loads where they grow.
   function place_text(step, part) result(text)
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      character(:), allocatable :: text
      text = 't = '//as_text(time_of(step, part), 8)
      if (step%ramp) text = text//', load factor '//as_text(part, 8)
   end function place_text

   !> Adds a line to what the user is told.
   pure subroutine tell(statics, text)
      type(statics_type), intent(inout) :: statics
      character(*), intent(in) :: text
      statics%report = statics%report//newline//'      '//text
   end subroutine tell

end module limber_analysis_static_branch
