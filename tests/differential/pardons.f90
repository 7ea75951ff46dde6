!> What a warning excuses. A warning tells how wrong a run may be; a difference is excused up to a stated multiple of that, in the
!> quantities that the warning speaks of, and no further. Warnings of a model (its range, its modes) excuse nothing: all views of a
!> scene have the same model.
module pardons
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use couplings, only: places, angles, speeds, spins, accelerations, forces, moments, energies, stresses, powers
   implicit none
   private
   public :: drawn_words, pardoned, without_near_ones, keeps_up, is_of_run, tells_of_vibrations

   !> Multiple of what is told that a channel may be off
   real(wp), parameter :: multiple = 5.0_wp
   !> A part x of the energy that is lost in vibrations is a part sqrt(x) of their speeds; accelerations and forces are those of the
   !> vibrations first of all
   real(wp), parameter :: of_vibrations = 10.0_wp
   !> Warnings that begin at a part of something: what stands before the number and behind it, and the part at which they begin
   character(*), parameter :: energy_words = 'energy balance is off by ', ringing_words = ' may err by about ', &
      & slip_words = 'they are off by ', phase_words = 'the motion is ', price_words = 'longer shows: up to ', &
      & inertia_words = "' errs by about "
   character(*), parameter :: kept_words = 'keeps up a vibration', unfollowed_words = 'does not follow a vibration', &
      & beyond_functions = 'do not follow', drawn_words = 'is drawn in by its bending'
   !> A warning that begins below a part of something
   character(*), parameter :: grip_words = 'lost their grip but for '
   real(wp), parameter :: energy_begins = 1.0e-2_wp, ringing_begins = 1.0e-2_wp, slip_begins = 2.0e-2_wp, &
      & phase_begins = 2.0e-2_wp, price_begins = 1.0e4_wp, grip_begins = 1.0e-2_wp, inertia_begins = 1.0e-2_wp
   !> A warning that tells less than so many times the part at which it begins may be missing in another view
   real(wp), parameter :: near = 10.0_wp

contains

   !> Part of the largest of its group that a channel may be off, by what a run warns of.
   pure real(wp) function pardoned(warnings, group) result(part)
      character(*), intent(in) :: warnings
      !> Of the channel
      integer, intent(in) :: group
      integer :: first, last
      part = 0.0_wp
      first = 1
      do while (first <= len(warnings))
         last = first + index(warnings(first:)//newline, newline) - 2
         part = max(part, by_line(warnings(first:last), group))
         first = last + 2
      end do
   end function pardoned

   !> The same of one warning.
   pure real(wp) function by_line(line, group) result(part)
      character(*), intent(in) :: line
      integer, intent(in) :: group
      logical :: of_forces
      of_forces = any(group == [accelerations, forces, moments, stresses, powers])
      part = 0.0_wp
      if (index(line, energy_words) > 0) then
         part = 0.01_wp*number_behind(line, energy_words)
         if (group /= energies) part = sqrt(part)
         if (of_forces) part = of_vibrations*part
      else if (index(line, ringing_words) > 0) then
         if (of_forces) part = 0.01_wp*number_behind(line, ringing_words)
      else if (index(line, slip_words) > 0) then
         if (all(group /= [places, angles])) part = 0.01_wp*number_behind(line, slip_words)
      else if (index(line, phase_words) > 0) then
         part = number_behind(line, ' by about ')
      else if (index(line, 'lose their grip on the motion: forces') > 0) then
         if (of_forces) part = huge(part)/multiple
      else if (index(line, 'another branch') > 0 .or. index(line, 'sets the scale of the errors') > 0) then
         part = huge(part)/multiple
      end if
      part = multiple*part
   end function by_line

   !> Warnings without those that are so near the part at which they begin that another view may not have them; and of a scene that
   !> is at rest, or not loaded, without those of vibrations that round-off sets off, in one view or another.
   pure function without_near_ones(warnings, idle) result(left)
      character(*), intent(in) :: warnings
      logical, intent(in) :: idle
      character(:), allocatable :: left
      integer :: first, last
      left = ''
      first = 1
      do while (first <= len(warnings))
         last = first + index(warnings(first:)//newline, newline) - 2
         associate (line => warnings(first:last))
            if (.not. (is_near(line, energy_words, 0.01_wp, energy_begins) .or. is_near(line, ringing_words, 0.01_wp, &
               & ringing_begins) .or. is_near(line, inertia_words, 0.01_wp, inertia_begins) .or. &
               & is_near(line, slip_words, 0.01_wp, slip_begins) .or. is_near(line, ' by about ', 1.0_wp, &
               & phase_begins) .or. is_near(line, price_words, 1.0_wp, price_begins) .or. &
               & (index(line, grip_words) > 0 .and. 0.01_wp*number_behind(line, grip_words) > grip_begins/near) .or. &
               & (idle .and. index(line, kept_words) > 0))) left = left//line//newline
         end associate
         first = last + 2
      end do
   end function without_near_ones

   !> Whether a run tells of a vibration that ADAMS keeps up.
   pure logical function keeps_up(warnings)
      character(*), intent(in) :: warnings
      keeps_up = index(warnings, kept_words) > 0
   end function keeps_up

   !> Whether a run tells of vibrations that its integrator keeps up or does not follow.
   pure logical function tells_of_vibrations(warnings)
      character(*), intent(in) :: warnings
      tells_of_vibrations = keeps_up(warnings) .or. index(warnings, unfollowed_words) > 0
   end function tells_of_vibrations

   !> Whether a warning is of one run by one integrator, which another run of the same scene need not share: what functions make of
   !> vibrations that the integrator has made is one, too.
   pure logical function is_of_run(line, warnings)
      !> The warning, and all of its run
      character(*), intent(in) :: line, warnings
      is_of_run = keeps_up(line) .or. index(line, unfollowed_words) > 0 .or. (index(line, beyond_functions) > 0 .and. &
         & (index(warnings, unfollowed_words) > 0 .or. keeps_up(warnings)))
   end function is_of_run

   pure logical function is_near(line, words, unit, begins)
      character(*), intent(in) :: line, words
      real(wp), intent(in) :: unit, begins
      is_near = index(line, words) > 0
      if (is_near) is_near = unit*number_behind(line, words) < near*begins
   end function is_near

   !> The number behind some words; 0 if there is none.
   pure real(wp) function number_behind(line, words) result(number)
      character(*), intent(in) :: line, words
      integer :: first, last, status
      number = 0.0_wp
      first = index(line, words)
      if (first == 0) return
      first = first + len(words)
      last = first + index(line(first:)//' ', ' ') - 2
      read (line(first:last), *, iostat=status) number
      if (status /= 0) number = 0.0_wp
   end function number_behind

end module pardons
