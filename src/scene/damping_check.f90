!> Check of damping ratios against the modes of the scene. The damping of a body acts on its own coordinates alone: where springs,
!> or other bodies that deflect, have a part in a vibration it may get another one. Floor: scene. Source: doc/theory, eqs. (3.43),
!> (3.44).
module limber_scene_damping_check
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_beam_reduced_body, only: damping_power
   use limber_model_model, only: model_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_multibody_modal_damping, only: damped_modes_type
   use limber_multibody_system, only: system_type
   use limber_multibody_small_vibrations, only: vibrations_type
   use limber_multibody_tangent, only: tangent_type
   use limber_multibody_tangent_products, only: times_damping
   implicit none
   private
   public :: damping_warning, changed_damping

   !> Modes that are looked at, from the lowest on, in which damped bodies have at least a part of the strain energy; and the
   !> relative error of a ratio that is not told. Under loads, modes of which damped bodies have most of the strain energy
   integer, parameter :: looked = 5
   real(wp), parameter :: least_share = 0.1_wp, most_share = 0.5_wp, little = 0.03_wp
   !> What is told
   character(*), parameter :: of_critical = ' of the critical damping instead of '
   !> Part of the largest ratio that is asked for beside which errors of others count
   real(wp), parameter :: least_asked = 0.1_wp

contains

   !> The lowest mode that has another ratio than is asked for, and the one that errs most; body 0 if none does.
   subroutine damping_warning(model, modes, body, text, hint)
      type(model_type), intent(in) :: model
      type(damped_modes_type), intent(in) :: modes
      !> The damped body with the largest part in the first of them
      integer, intent(out) :: body
      character(:), allocatable, intent(out) :: text, hint
      logical :: damped(size(model%bodies))
      real(wp) :: error, largest
      integer :: i, j, seen, first, worst
      body = 0
      text = ''
      hint = ''
      if (.not. modes%found) return
      if (.not. any(modes%asked > 0.0_wp)) return
      damped = [(allocated(model%bodies(i)%ratio), i=1, size(damped))]
      first = 0
      worst = 0
      seen = 0
      largest = 0.0_wp
      do j = 1, size(modes%frequency)
         if (sum(modes%share(:, j), mask=damped) < least_share) cycle
         seen = seen + 1
         if (seen > looked) exit
         error = ratio_error(modes%ratio(j), modes%dampers(j), modes%asked(j), least_asked*maxval(modes%asked))
         if (error < little) cycle
         if (first == 0) first = j
         if (error > largest) worst = j
         largest = max(largest, error)
      end do
      if (first == 0) return
      body = maxloc(modes%share(:, first), dim=1, mask=damped)
      text = "damping of '"//name_in_deck(model, body)//"': the scene vibrates at "//ratio_text(model, modes, first)//', '// &
         & cause_text(model, modes, body, first)
      if (worst /= first) text = text//'; at '//ratio_text(model, modes, worst)
      hint = 'the damping acts on the deflections of the body alone: '//remedy_text(model, modes, body, first)
   end subroutine damping_warning

   !> A warning where loads, heat or another position have changed what vibrations about a state have of the damping of their
   !> bodies:
   !> of the mode that errs most; empty if none does, or if some do so from the first position on.
   function changed_damping(system, tangent, vibrations, told, where) result(text)
      type(system_type), intent(in) :: system
      !> Linearised at the state
      type(tangent_type), intent(in) :: tangent
      !> Of unit modal mass
      type(vibrations_type), intent(in) :: vibrations
      !> Warnings so far; the analysis, "*MODES 'small'"
      character(*), intent(in) :: told, where
      character(:), allocatable :: text
      real(wp) :: ratio, dampers, asked, error, largest, worst(3)
      integer :: j, body, mode, culprit
      text = ''
      if (index(told, of_critical) > 0) return
      largest = little
      mode = 0
      do j = 1, size(vibrations%frequency)
         if (.not. vibrations%frequency(j) > 0.0_wp) cycle
         call weigh(system, tangent, vibrations%shape(:, j), hypot(vibrations%frequency(j), vibrations%growth(j)), ratio, dampers, &
            & asked, body)
         if (body == 0) cycle
         error = ratio_error(ratio, dampers, asked, 0.0_wp)
         if (error <= largest) cycle
         largest = error
         mode = j
         culprit = body
         worst = told_numbers(ratio, dampers, asked, 0.0_wp)
      end do
      if (mode == 0) return
      text = "warning: damping of '"//name_in_deck(system%model, culprit)//"': in "//where//' the mode at '// &
         & as_text(vibrations%frequency(mode), 4)//' rad/'//system%model%units%time//' has '//as_text(worst(1), 3)// &
         & of_critical//as_text(worst(2), 3)//', since loads, or another position, have changed its frequency since the start; '// &
         & 'use a RATIO that is '//as_text(worst(3), 2)//' times as large, or RAYLEIGH BETA'//newline
   end function changed_damping

   !> Relative error of a ratio: what bodies and dampers lack together of that asked for, or what bodies have beyond it, as a part
   !> of all that damps the mode, eq. (3.44).
   pure real(wp) function ratio_error(ratio, dampers, asked, least) result(error)
      !> Of the bodies, of all else that damps, as it is asked for; below which one counts as this
      real(wp), intent(in) :: ratio, dampers, asked, least
      real(wp) :: filling
      ! What feeds a vibration is no lack of the bodies
      filling = max(dampers, 0.0_wp)
      error = max(asked - ratio - filling, 0.0_wp)
      if (ratio > asked) error = ratio - asked
      error = error/max(asked + merge(filling, 0.0_wp, ratio > asked), least)
   end function ratio_error

   !> What is told of a mode: its ratio, what that should be, and how many times as large the ratio of the body must be for it.
   !> Dampers fill up what is lacking, and come on top of what is too much.
   pure function told_numbers(ratio, dampers, asked, least) result(told)
      !> As of `ratio_error`
      real(wp), intent(in) :: ratio, dampers, asked, least
      real(wp) :: told(3), filling
      filling = max(dampers, 0.0_wp)
      told = [ratio + filling, asked + filling, asked]
      if (ratio < asked) told(2:) = [asked, asked - filling]
      told(3) = told(3)/max(ratio, 1.0e-6_wp*max(asked, least))
   end function told_numbers

   !> What a vibration has of the damping of its bodies and of other dampers, and what the bodies ask for, eq. (3.43); body 0: it is
   !> not one of these bodies, which have less than most of its strain energy.
   subroutine weigh(system, tangent, shape, speed, ratio, dampers, asked, body)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw), of unit modal mass; its |s| [1/time]
      complex(wp), intent(in) :: shape(:)
      real(wp), intent(in) :: speed
      real(wp), intent(out) :: ratio, dampers, asked
      !> The damped one with the largest part
      integer, intent(out) :: body
      real(wp) :: share, flexible, damped, most, own_part
      integer :: i, first, last
      ratio = 0.0_wp
      dampers = 0.5_wp/speed*(damping_of(system, tangent, real(shape, wp)) + damping_of(system, tangent, aimag(shape)))
      asked = 0.0_wp
      flexible = 0.0_wp
      damped = 0.0_wp
      most = 0.0_wp
      body = 0
      do i = 1, size(system%model%bodies)
         if (system%layout%n(i) == 0) cycle
         first = system%layout%w(i) + system%layout%rates(i)
         last = first + system%layout%n(i) - 1
         associate (eta => shape(first:last), own => system%model%bodies(i))
            share = sum(own%reduced%omega2*abs(eta)**2)/speed**2
            flexible = flexible + share
            if (.not. allocated(own%ratio)) cycle
            ! What modes of their own ask for is not known here
            if (maxval(own%ratio) > minval(own%ratio)) return
            damped = damped + share
            own_part = 0.5_wp/speed*(damping_power(own%reduced, real(eta, wp)) + damping_power(own%reduced, aimag(eta)))
            dampers = dampers - own_part
            ratio = ratio + own_part - 0.5_wp*own%rayleigh(2)*share*speed
            asked = asked + share*(own%ratio(1) + 0.5_wp*own%rayleigh(1)/speed)
            if (share <= most) cycle
            most = share
            body = i
         end associate
      end do
      if (damped < most_share .or. .not. asked > 0.0_wp) body = 0
      asked = asked/max(flexible, tiny(1.0_wp))
   end subroutine weigh

   !> Power that all velocity terms take from a motion.
   real(wp) function damping_of(system, tangent, motion) result(power)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw)
      real(wp), intent(in) :: motion(:)
      real(wp) :: product(size(motion))
      product = 0.0_wp
      call times_damping(system, tangent, 1.0_wp, motion, product)
      power = dot_product(product, motion)
   end function damping_of

   !> The remedy: what damps the other parts, or a ratio that this mode has then.
   function remedy_text(model, modes, body, mode) result(text)
      type(model_type), intent(in) :: model
      type(damped_modes_type), intent(in) :: modes
      integer, intent(in) :: body, mode
      character(:), allocatable :: text
      real(wp) :: told(3)
      told = told_numbers(modes%ratio(mode), modes%dampers(mode), modes%asked(mode), maxval(modes%asked))
      if (2*modes%springs(mode) > 1.0_wp) then
         text = 'give the springs and bushings DAMPING'
      else if (model%bodies(body)%whole > 0) then
         text = 'RAYLEIGH BETA means the same for any number of segments; or use a RATIO that is '// &
            & as_text(told(3), 2)//' times as large for this mode'
      else
         text = 'use a RATIO that is '//as_text(told(3), 2)// &
            & ' times as large for this mode, or RAYLEIGH BETA'
      end if
   end function remedy_text

   !> "12.3 rad/s with 0.0188 of the critical damping, where 0.02 is asked for".
   function ratio_text(model, modes, mode) result(text)
      type(model_type), intent(in) :: model
      type(damped_modes_type), intent(in) :: modes
      integer, intent(in) :: mode
      character(:), allocatable :: text
      real(wp) :: told(3)
      told = told_numbers(modes%ratio(mode), modes%dampers(mode), modes%asked(mode), maxval(modes%asked))
      text = as_text(modes%frequency(mode), 4)//' rad/'//model%units%time//' with '//as_text(told(1), 3)//of_critical// &
         & as_text(told(2), 3)
   end function ratio_text

   !> What else has a part in the mode.
   function cause_text(model, modes, body, mode) result(text)
      type(model_type), intent(in) :: model
      type(damped_modes_type), intent(in) :: modes
      integer, intent(in) :: body, mode
      character(:), allocatable :: text
      real(wp) :: own
      integer :: i
      own = 0.0_wp
      do i = 1, size(model%bodies)
         if (i == body .or. (model%bodies(body)%whole > 0 .and. model%bodies(i)%whole == model%bodies(body)%whole)) &
            & own = own + modes%share(i, mode)
      end do
      if (own + modes%springs(mode) > 0.99_wp .and. own > 0.5_wp .and. model%bodies(body)%whole > 0) then
         text = 'since each of its pieces is damped by itself'
      else if (modes%springs(mode) > 1 - own - modes%springs(mode)) then
         text = 'since springs hold '//percent(modes%springs(mode))//' of its energy'
      else
         text = 'since other bodies have '//percent(1 - own - modes%springs(mode))//' of its strain energy'
      end if
   end function cause_text

   function percent(part) result(text)
      real(wp), intent(in) :: part
      character(:), allocatable :: text
      text = as_text(100*part, 2)//' %'
   end function percent

end module limber_scene_damping_check
