!> Warnings of exact beams with too few functions. Of the deflection, and of the bending moments, shear forces and reactions that
!> channels ask for, with the cause (the shape that they cannot have, sudden or fast loads, much tension) and the remedy. All limits
!> stand here. Floor: monitor. Source: doc/theory, eqs. (7.54), (7.55), (7.58)-(7.62), (7.65), (7.70), (7.71).
module limber_monitor_function_report
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_monitor_function_channels, only: asks_along, shows_place, asks_moment, lost_of_channels, of_moments, &
      & of_forces, of_pulls
   use limber_monitor_function_buckling, only: buckles_unseen
   use limber_monitor_function_layers, only: layers_type, lost_in_layers
   use limber_monitor_function_sudden, only: lost_deflection, is_struck, find_brevity
   use limber_monitor_function_watch, only: function_watch_type
   use limber_monitor_met_ends, only: met_ends_warnings
   use limber_monitor_noise, only: noise_of
   use limber_model_model, only: most_bends, place_on_beam, model_type
   implicit none
   private
   public :: function_warnings, ring_warnings

   !> Parts of the largest deflection that may be left out, by the functions of the angle and by those of the strain, and parts of
   !> the length that are too small to count
   real(wp), parameter :: allowed(2) = [2.0e-3_wp, 2.0e-3_wp], least(2) = [1.0e-6_wp, 1.0e-4_wp]
   !> The latter for stretch of a beam whose displacements along it are asked for: against these then
   real(wp), parameter :: least_along = 1.0e-10_wp
   !> Largest error of a deflection by vibrations, of moments, and of forces across and along the beam; error beyond which it is one
   !> of the size of the whole
   real(wp), parameter :: little = 5.0e-3_wp, little_force(3) = [1.2e-2_wp, 1.5e-2_wp, 1.5e-2_wp], all_of_it = 1.0_wp
   !> What recommended functions are to leave of sudden loads, and most of these
   real(wp), parameter :: aim = 2.0e-2_wp
   integer, parameter :: most_functions = 40
   !> How far the layers of the functions may be from that of the tension
   real(wp), parameter :: alike = 1.3_wp

   !> What is told of one beam, or of all pieces of one
   type :: report_type
      !> First and last of the watched beams; name
      integer :: first = 0, last = 0
      character(:), allocatable :: name
      !> Parts beyond their limits that err, 0 for others: of the deflection by the shape and by vibrations, of moments in layers
      !> and
      !> at rest, of moments and forces by vibrations; pieces of the first and the third
      real(wp) :: rest = 0.0_wp, late = 0.0_wp, layers = 0.0_wp, moments = 0.0_wp, lost(3) = 0.0_wp
      integer :: worst = 0, taut = 0
      !> Causes, what errs, and remedies
      character(:), allocatable :: causes, what, remedies
   end type report_type

contains

   !> A warning for each beam that has too few functions of the angle, and one for those of the strain. The pieces of a beam are
   !> told of as one, with the largest of their parts: their displacements add up.
   function function_warnings(self, model, times) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      !> How many times beyond its limit an error must be
      real(wp), intent(in) :: times
      character(:), allocatable :: text
      type(report_type) :: report
      text = met_ends_warnings(self%ends, model)
      do while (report%last < size(self%beams))
         call next_beam(self, model, report)
         call weigh(self, model, times, report)
         text = text//angle_warning(self, model, report)//strain_warning(self, model, times, report) &
            & //ring_warning(self, model, report)//buckling_warning(self, report)
      end do
   end function function_warnings

   !> The warnings of vibrations along beams alone.
   function ring_warnings(self, model) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      type(report_type) :: report
      text = ''
      do while (report%last < size(self%beams))
         call next_beam(self, model, report)
         call weigh(self, model, 1.0_wp, report)
         text = text//ring_warning(self, model, report)
      end do
   end function ring_warnings

   !> The next beam, all its pieces.
   subroutine next_beam(self, model, report)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      type(report_type), intent(inout) :: report
      report%first = report%last + 1
      report%last = last_piece(self, model, report%first)
      associate (body => model%bodies(self%beams(report%first)%body))
         report%name = body%name
         if (body%whole > 0) report%name = model%wholes(body%whole)%name
      end associate
   end subroutine next_beam

   !> The last piece of a beam, whose first one is given.
   pure integer function last_piece(self, model, first) result(last)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      integer, intent(in) :: first
      last = first
      associate (whole => model%bodies(self%beams(first)%body)%whole)
         do while (whole > 0 .and. last < size(self%beams))
            if (model%bodies(self%beams(last + 1)%body)%whole /= whole) exit
            last = last + 1
         end do
      end associate
   end function last_piece

   !> Finds what errs beyond its limit.
   subroutine weigh(self, model, times, report)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: times
      type(report_type), intent(inout) :: report
      real(wp) :: moved, across, length, left_out, sure
      integer :: k
      report%rest = 0.0_wp
      report%late = 0.0_wp
      report%lost = 0.0_wp
      report%layers = 0.0_wp
      report%moments = 0.0_wp
      associate (beams => self%beams(report%first:report%last))
         moved = maxval(beams%moved)*size(beams)
         across = maxval(beams%moved_by_angle)*size(beams)
         length = sum([(model%bodies(beams(k)%body)%reduced%exact%total, k=1, size(beams))])
         report%worst = report%first - 1 + maxloc(beams%left_out(1), dim=1)
         left_out = maxval(beams%left_out(1))
         if (left_out > least(1)*model%bodies(beams(1)%body)%reduced%exact%total) &
            & report%rest = left_out/max(across, left_out)
         report%taut = report%first
         do k = report%first, report%last
            if (lost_in_layers(self%beams(k)%layers) > lost_in_layers(self%beams(report%taut)%layers)) report%taut = k
            ! What is left of less is the integrator's
            if (.not. moved > noise_of(model%dynamics%tolerance)*length) cycle
            report%late = max(report%late, lost_deflection(self%beams(k)%sudden)/moved)
            report%lost = max(report%lost, lost_of_channels(self, self%beams(k), model))
         end do
         if (.not. shows_place(model, beams%body)) report%late = 0.0_wp
         if (asks_moment(model, beams%body)) then
            report%layers = lost_in_layers(self%beams(report%taut)%layers)
            ! Of all pieces: a moment that one has at its end is that of the next one
            report%moments = maxval(beams%moment_off)/max(maxval(beams%moment), tiny(moved))
         end if
      end associate
      if (report%rest <= times*allowed(1)) report%rest = 0.0_wp
      if (report%late <= times*little) report%late = 0.0_wp
      if (report%layers <= times*little_force(of_moments)) report%layers = 0.0_wp
      if (report%moments <= times*little_force(of_moments)) report%moments = 0.0_wp
      ! What a mass does to a beam along which it slides is known to half of that only
      sure = 1.0_wp
      if (room(model, self%beams(report%first)%body) < huge(k)) sure = 0.5_wp
      where (report%lost <= sure*times*little_force) report%lost = 0.0_wp
   end subroutine weigh

   !> Of the functions of the angle: the larger one of what is left out of the shape and of the vibrations, and what errs of forces.
   function angle_warning(self, model, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      type(report_type), intent(inout) :: report
      character(:), allocatable :: text, more
      real(wp) :: sudden, moments
      integer :: functions
      text = ''
      report%causes = ''
      report%what = ''
      report%remedies = ''
      functions = model%bodies(self%beams(report%first)%body)%choice%exact%angles
      sudden = max(report%late, maxval(report%lost(:of_forces)))
      moments = max(report%lost(of_moments), report%layers, report%moments)
      if (max(report%rest, report%late, moments, report%lost(of_forces)) <= 0.0_wp) return
      if (report%rest > report%late .or. report%moments > 0.0_wp) call add(report%causes, ' and ', &
         & 'all of its shape at t = '//as_text(self%beams(report%worst)%when(1), 4))
      if (sudden > 0.0_wp) call add(report%causes, ' and ', 'its vibrations under sudden or fast loads' &
         & //brevity(self, model, report))
      if (max(report%rest, report%late) > 0.0_wp) call add_error(report, max(report%rest, report%late), 'its largest deflection')
      if (moments > 0.0_wp) call add_error(report, moments, 'bending moments asked for')
      if (report%lost(of_forces) > 0.0_wp) call add_error(report, report%lost(of_forces), 'shear forces and reactions asked for')
      if (report%layers > 0.0_wp) then
         associate (beam => self%beams(report%taut))
            call add(report%causes, ' and ', words_of(beam%layers, model, beam%body))
            call add(report%remedies, ' and ', remedy_of(beam%layers, model, beam%body))
         end associate
      end if
      if (max(report%rest, report%moments, sudden) > 0.0_wp) then
         more = functions_for(sudden, functions, most_angles(model, self%beams(report%first)%body), slower(self, report))
         if (index(more, report%remedies) == 1) report%remedies = ''
         if (index(report%remedies, more) == 0) call add(report%remedies, ' and ', more)
      end if
      text = "warning: beam '"//report%name//"' has too few functions of the angle: its "//as_text(functions)//' do not follow '// &
         & report%causes//'; '//report%what//' may be off; use '//report%remedies//newline
   end function angle_warning

   !> How long moments and forces are off behind each jump, where that is short.
   function brevity(self, model, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      type(report_type), intent(in) :: report
      character(:), allocatable :: text
      logical :: brief
      real(wp) :: time, longest
      integer :: k
      text = ''
      if (report%late > 0.0_wp) return
      longest = 0.0_wp
      do k = report%first, report%last
         call find_brevity(self%beams(k)%sudden, brief, time)
         if (.not. brief) return
         longest = max(longest, time)
      end do
      text = ', for about '//as_text(longest, 2)//' '//model%units%time//' after a jump, until damping ends them'
   end function brevity

   !> Adds one more to a list of words.
   pure subroutine add(list, link, word)
      character(:), allocatable, intent(inout) :: list
      character(*), intent(in) :: link, word
      if (list /= '') list = list//link
      list = list//word
   end subroutine add

   !> Adds what errs.
   pure subroutine add_error(report, error, name)
      type(report_type), intent(inout) :: report
      real(wp), intent(in) :: error
      character(*), intent(in) :: name
      if (error > all_of_it) then
         call add(report%what, ', ', '100 % or more of '//name)
      else
         call add(report%what, ', ', 'about '//as_text(100*error, 2)//' % of '//name)
      end if
   end subroutine add_error

   !> Functions for sudden loads: errors of forces fall about as one over their number.
   pure function functions_for(error, functions, most, otherwise) result(text)
      real(wp), intent(in) :: error
      !> Number of them, and most that the beam can have
      integer, intent(in) :: functions, most
      !> What else helps against sudden loads
      character(*), intent(in) :: otherwise
      character(:), allocatable :: text
      integer :: better, allowed_here
      better = nint(functions*max(2.0_wp, min(error, 1.0e3_wp)/aim))
      allowed_here = min(most, max(2*functions, min(better, most_functions)))
      text = otherwise
      if (allowed_here <= functions) return
      text = 'FUNCTIONS='//as_text(allowed_here)
      if (allowed_here == most .and. better > most) text = text//', all that a beam can have along which a point slides'
      if (better > allowed_here .or. (error > 0.0_wp .and. index(otherwise, '*') > 0)) text = text//', or '//otherwise
   end function functions_for

   !> What else helps against vibrations of a beam, by what sets them off.
   pure function slower(self, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(report_type), intent(in) :: report
      character(:), allocatable :: text
      integer :: k
      text = 'loads that change more slowly'
      do k = report%first, report%last
         if (is_struck(self%beams(k)%sudden)) text = &
            & '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC, for it is the start without deflections that sets them off'
      end do
   end function slower

   !> Most coordinates of a body: fewer where a point slides along it.
   pure integer function room(model, body) result(most)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer :: i
      most = huge(most)
      do i = 1, size(model%joints)
         if (model%joints(i)%place /= place_on_beam) cycle
         if (model%points(model%joints(i)%points(2))%body == body) most = most_bends
      end do
   end function room

   !> Most FUNCTIONS= that a beam can have: beside them are coordinates of the strain, of a tension, of what loads and joints
   !> between its ends add, and of the shear, one more for each.
   pure integer function most_angles(model, body) result(most)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      associate (own => model%bodies(body), exact => model%bodies(body)%reduced%exact)
         most = room(model, body) - (own%reduced%n - own%choice%exact%angles - exact%shears)
         if (exact%shears > 0) most = most/2
      end associate
   end function most_angles

   !> 'STRAIN FUNCTIONS=...': twice as many, as far as the beam can have them; empty if it has all.
   pure function strains_for(model, body) result(text)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      character(:), allocatable :: text
      integer :: more
      associate (own => model%bodies(body))
         more = min(max(3, 2*own%choice%exact%strains), room(model, body) - own%reduced%n + own%choice%exact%strains)
         text = ''
         if (more > own%choice%exact%strains) text = 'STRAIN FUNCTIONS='//as_text(more)
      end associate
   end function strains_for

   !> Where layers are.
   pure function words_of(layers, model, body) result(text)
      type(layers_type), intent(in) :: layers
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      character(:), allocatable :: text
      real(wp) :: tautness
      associate (exact => model%bodies(body)%reduced%exact)
         tautness = layers%tension*exact%total**2/model%bodies(body)%beam%ei
         text = 'how a tension of '//as_text(layers%tension, 3)//' ('//as_text(tautness, 2)//' E I/L^2) bends it near '
         if (.not. layers%at > 0.0_wp) then
            text = text//'its start'
         else if (.not. layers%at < exact%total) then
            text = text//'its end'
         else
            text = text//'s = '//as_text(layers%at, 4)
         end if
         text = text//' within '//as_text(1/sqrt(tautness), 2)//' of its length at t = '//as_text(layers%when, 4)
      end associate
   end function words_of

   !> What to do about layers.
   pure function remedy_of(layers, model, body) result(text)
      type(layers_type), intent(in) :: layers
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      character(:), allocatable :: text
      associate (own => model%bodies(body))
         text = 'TENSION='//as_text(layers%tension, 2)
         if (own%whole > 0) then
            if (allocated(model%wholes(own%whole)%lean)) text = 'a *BEAM with '//text//' for this member'
         end if
         if (.not. allocated(own%choice%exact%layers)) return
         if (size(own%choice%exact%layers) == 0) return
         if (own%choice%exact%layers(1) < alike*sqrt(own%beam%ei/layers%tension)) &
            & text = 'FUNCTIONS='//as_text(min(2*own%choice%exact%angles, most_angles(model, body)))
      end associate
   end function remedy_of

   !> Of the functions of the strain.
   function strain_warning(self, model, times, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: times
      type(report_type), intent(in) :: report
      character(:), allocatable :: text
      character(27) :: beside
      real(wp) :: part, moved, floor_of
      integer :: worst
      text = ''
      associate (beams => self%beams(report%first:report%last), body => model%bodies(self%beams(report%first)%body))
         moved = maxval(beams%moved)*size(beams)
         floor_of = least(2)*body%reduced%exact%total
         beside = 'displacement'
         if (asks_along(model, body%whole, beams%body)) then
            moved = maxval(beams%moved_along)*size(beams)
            floor_of = least_along*body%reduced%exact%total
            beside = 'displacement along its axis'
         end if
         worst = maxloc(beams%left_out(2), dim=1)
         part = beams(worst)%left_out(2)/max(moved, beams(worst)%left_out(2), tiny(moved))
         if (part <= times*allowed(2) .or. beams(worst)%left_out(2) <= floor_of) return
         text = "warning: beam '"//report%name//"' has too few functions of the strain: they leave out about "// &
            & as_text(100*part, 2)//' % of its largest '//trim(beside)//' at t = '//as_text(beams(worst)%when(2), 4)
         if (strains_for(model, beams(1)%body) /= '') text = text//'; use '//strains_for(model, beams(1)%body)
         text = text//newline
      end associate
   end function strain_warning

   !> Of vibrations along the beam.
   function ring_warning(self, model, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      type(report_type), intent(inout) :: report
      character(:), allocatable :: text
      text = ''
      if (.not. report%lost(of_pulls) > 0.0_wp) return
      report%what = ''
      call add_error(report, report%lost(of_pulls), 'axial forces and reactions asked for')
      associate (strains => model%bodies(self%beams(report%first)%body)%choice%exact%strains)
         text = "warning: beam '"//report%name//"' vibrates along itself under sudden or fast loads in ways that its "// &
            & as_text(strains)//trim(merge(' function ', ' functions', strains == 1))//' of the strain do not follow: '// &
            & report%what//' may be off; use '
         if (strains_for(model, self%beams(report%first)%body) /= '') &
            & text = text//strains_for(model, self%beams(report%first)%body)//', '
         text = text//'STRAIN FUNCTIONS=0 to leave these vibrations out, or '//slower(self, report)//newline
      end associate
   end function ring_warning

   !> Of a beam that is compressed beyond Euler's load while nothing pushes it across, eqs. (7.68), (7.69).
   function buckling_warning(self, report) result(text)
      type(function_watch_type), intent(in) :: self
      type(report_type), intent(in) :: report
      character(:), allocatable :: text
      integer :: k, worst
      text = ''
      worst = 0
      do k = report%first, report%last
         if (.not. buckles_unseen(self%beams(k)%buckling)) cycle
         if (worst == 0) worst = k
         if (self%beams(k)%buckling%worst > self%beams(worst)%buckling%worst) worst = k
      end do
      if (worst == 0) return
      text = "warning: beam '"//report%name//"' is compressed by "//as_text(self%beams(worst)%buckling%worst, 2)// &
         & ' times its Euler load at t = '//as_text(self%beams(worst)%buckling%when, 4)//' and stays straight, since nothing'// &
         & ' pushes it across: its buckling would begin with round-off. Give it what a real beam has, a CURVATURE or a small'// &
         & ' force across; *STATICS finds the load at which it buckles'//newline
   end function buckling_warning

end module limber_monitor_function_report
