!> Judgement of the indicators and their warnings. Judges the indicators of a run, warns where a model was used outside its range,
!> and writes them to the result file. What error a model makes at the limits is measured in doc/fidelity.md. Floor: monitor.
!> Source: doc/theory, eqs. (7.8)-(7.11), (7.15)-(7.17), (7.21), (7.25)-(7.27), (7.32)-(7.35).
module limber_monitor_model_ranges
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_monitor_function_report, only: function_warnings
   use limber_monitor_indicators, only: indicators_type, body_indicators_type, indicator_value, indicator_time, &
      & indicator_names, indicator_meanings, layer_errors, peak_unstretched, peak_growth, slow, &
      & indicator_count, indicator_deflection, indicator_slope, indicator_rotation, &
      & indicator_compression, indicator_pace, indicator_residual, indicator_geometric, indicator_stiffening, &
      & indicator_axial, indicator_coarseness, &
      & indicator_lumping, indicator_shortening, indicator_drift, indicator_elongation, indicator_recoil, &
      & indicator_buckling, indicator_layer, indicator_phase, indicator_false_damping, indicator_membrane, indicator_reaction, &
      & indicator_recoil_force, indicator_drawn, indicator_strain, indicator_sudden, sudden_errors
   use limber_model_model, only: model_type, body_type
   use limber_output_history, only: history_type
   implicit none
   private
   public :: range_warnings, record_indicators, excess, likely_cause

   !> Why a frame lacks axial force
   character(*), parameter :: held_apart = ': its joints or its other members hold the ends of members apart as these bend'
   !> Forces that err near ends under tension, and under sudden loads
   character(*), parameter :: layer_names(3) = [character(17) :: 'shear forces', 'bending moments', 'moments of joints'], &
      & sudden_names(5) = [character(29) :: 'axial forces', 'shear forces', 'bending moments', &
      & 'forces of joints and drivers', 'moments of joints and drivers']
   !> Part of the length below which a deflection is none, and part of the largest one of the scene below which it does not matter
   real(wp), parameter :: nothing = 1.0e-9_wp, negligible = 1.0e-3_wp
   !> Part of the length that no place shows
   real(wp), parameter :: unseen = 1.0e-5_wp
   !> Growth of a small deflection under a compression beyond Euler's load, as a logarithm, that makes it large
   real(wp), parameter :: much = 2.0_wp
   !> Shift of vibrations beyond which only this is told
   real(wp), parameter :: beyond = 0.5_wp
   !> Of a rigid beam: frequency of loads, relative to the first one, from which its deflection is more than at rest, and how much
   !> more at most
   real(wp), parameter :: quick = 0.5_wp, resonant = 10.0_wp

contains

   !> An indicator of a body relative to the limit of the body's model: outside its range above 1, zero where there is no limit.
   !> At the limits the deflections err by some per cent.
   pure real(wp) function excess(indicators, body, kind)
      type(body_indicators_type), intent(in) :: indicators
      type(body_type), intent(in) :: body
      !> One of indicator_...
      integer, intent(in) :: kind
      logical :: linear
      real(wp) :: limit, deflection
      if (indicators%is_rigid) then
         excess = rigid_excess(indicators, kind)
         return
      end if
      linear = .not. body%reduced%geometric
      limit = huge(1.0_wp)
      select case (kind)
      case (indicator_deflection)
         limit = 0.1_wp
      case (indicator_slope)
         limit = 0.3_wp
      case (indicator_rotation)
         if (linear) limit = 1.0_wp
      case (indicator_compression)
         if (linear) then
            limit = 0.5_wp
         else if (indicator_value(indicators, indicator_pace) < slow .or. indicators%peak(peak_growth) > much) then
            limit = 1.0_wp
         end if
      case (indicator_geometric)
         if (linear) limit = 0.03_wp
      case (indicator_stiffening)
         if (linear) limit = 0.03_wp
      case (indicator_axial)
         if (.not. linear) limit = 0.04_wp
      case (indicator_coarseness)
         if (.not. linear) limit = 0.05_wp
      case (indicator_residual)
         ! With dampers and springs internal forces err by some times as much
         limit = merge(0.015_wp, 0.05_wp, any([indicators%shows_shear, indicators%shows_moment, indicators%shows_reaction]))
      case (indicator_lumping)
         limit = 0.05_wp
      case (indicator_shortening)
         limit = 0.03_wp
      case (indicator_drift)
         limit = 0.015_wp
      case (indicator_phase, indicator_false_damping, indicator_membrane, indicator_reaction, &
         & indicator_recoil_force)
         limit = 0.03_wp
      case (indicator_elongation)
         limit = merge(0.02_wp, 0.05_wp, softens(indicators, body))
      case (indicator_recoil, indicator_drawn)
         limit = 0.05_wp
      case (indicator_sudden)
         limit = 0.03_wp
      case (indicator_buckling, indicator_layer)
         if (.not. linear) limit = 0.05_wp
      case (indicator_strain)
         if (.not. linear) limit = 0.02_wp
      end select
      excess = indicator_value(indicators, kind)/limit
      if (any(kind == [indicator_rotation, indicator_compression, indicator_buckling, indicator_phase])) return
      if (kind == indicator_elongation) then
         if (.not. indicators%peak(peak_unstretched) > max(nothing, indicators%noise)) excess = 0.0_wp
         return
      end if
      deflection = indicator_value(indicators, indicator_deflection)
      if (.not. deflection > max(nothing, indicators%noise)) excess = 0.0_wp
      ! Phase of vibrations too small to be seen in places; internal forces show them
      if (kind == indicator_stiffening .and. deflection*excess*limit < unseen .and. .not. any([indicators%shows_shear, &
         & indicators%shows_moment, indicators%shows_axial])) excess = 0.0_wp
   end function excess

   !> Whether the axial force in its axial functions softens a body much.
   pure logical function softens(indicators, body)
      type(body_indicators_type), intent(in) :: indicators
      type(body_type), intent(in) :: body
      !> Part of the buckling load
      real(wp), parameter :: much_of_it = 0.3_wp
      softens = body%reduced%geometric .and. indicator_value(indicators, indicator_compression) > much_of_it
   end function softens

   !> The same of a rigid beam: the deflection that it would have, its Euler load, and loads that change too quickly for the
   !> deflection to be that at rest, if that matters.
   pure real(wp) function rigid_excess(indicators, kind) result(excess)
      type(body_indicators_type), intent(in) :: indicators
      integer, intent(in) :: kind
      real(wp) :: deflection, pace
      deflection = indicator_value(indicators, indicator_deflection)/indicators%allowed
      excess = 0.0_wp
      select case (kind)
      case (indicator_deflection); excess = deflection
      case (indicator_compression); excess = indicator_value(indicators, kind)/0.5_wp
      case (indicator_pace)
         pace = indicator_value(indicators, kind)
         if (pace <= quick .or. deflection > 1.0_wp) return
         ! Up to the first frequency as of a forced vibration, beyond as of a load that is there at once
         excess = 2*deflection
         if (pace < 1.0_wp) excess = deflection*max(2.0_wp*pace, min(resonant, 1/(1 - pace**2)))
      end select
   end function rigid_excess

   !> Warnings of a run, one line after another, for each kind of indicator one, of the body that is worst; empty if all is within
   !> range.
   function range_warnings(indicators, model, times) result(text)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      !> How many times beyond its limit an indicator must be to be told; without it once
      real(wp), intent(in), optional :: times
      character(:), allocatable :: text
      real(wp) :: most, value, largest, least
      integer :: kind, i, worst, others
      text = ''
      least = 1.0_wp
      if (present(times)) least = times
      largest = 0.0_wp
      do i = 1, size(indicators%bodies)
         if (indicators%bodies(i)%is_rigid) cycle
         largest = max(largest, indicator_value(indicators%bodies(i), indicator_deflection)*indicators%bodies(i)%length)
      end do
      do kind = 1, indicator_count
         most = least
         worst = 0
         others = -1
         do i = 1, size(indicators%bodies)
            value = excess(indicators%bodies(i), model%bodies(indicators%bodies(i)%body), kind)
            if (.not. value > least) cycle
            if (is_told(indicators%bodies(i), model%bodies(indicators%bodies(i)%body), kind, value)) cycle
            if (all(kind /= [indicator_rotation, indicator_compression, indicator_elongation, indicator_buckling]) .and. &
               & indicators%bodies(i)%length*indicator_value(indicators%bodies(i), indicator_deflection) < negligible*largest) cycle
            others = others + 1
            if (.not. value > most) cycle
            most = value
            worst = i
         end do
         if (worst == 0) cycle
         associate (body => indicators%bodies(worst), of => model%bodies(indicators%bodies(worst)%body))
            text = text//'warning: '//trim(merge('frame', 'beam ', of%is_frame))//" '"//of%name//"'"
            if (others > 0) text = text//' (and '//as_text(others)//' more)'
            text = text//' '//what_is_wrong(body, of, kind)//'; '//what_to_do(body, of, kind, most)//newline
         end associate
      end do
      text = text//function_warnings(indicators%functions, model, least)
   end function range_warnings

   !> Whether another kind tells the same with a larger number: masses in the nodes are told once, and axial forces with the
   !> deflection that they change.
   pure logical function is_told(indicators, body, kind, value)
      type(body_indicators_type), intent(in) :: indicators
      type(body_type), intent(in) :: body
      integer, intent(in) :: kind
      !> Its excess
      real(wp), intent(in) :: value
      is_told = .false.
      if (kind == indicator_lumping) is_told = excess(indicators, body, indicator_phase) > value
      if (kind == indicator_reaction) is_told = excess(indicators, body, indicator_membrane) > 1.0_wp
      if (kind == indicator_phase) is_told = excess(indicators, body, indicator_lumping) >= value
   end function is_told

   !> The number, when, and why it matters.
   function what_is_wrong(indicators, body, kind) result(text)
      type(body_indicators_type), intent(in) :: indicators
      type(body_type), intent(in) :: body
      integer, intent(in) :: kind
      character(:), allocatable :: text
      character(:), allocatable :: value, percent, when, linear
      linear = 'a LINEAR '//trim(merge('frame', 'beam ', body%is_frame))
      value = as_text(indicator_value(indicators, kind), 2)
      percent = as_text(100*indicator_value(indicators, kind), 2)//' %'
      when = ' at t = '//as_text(indicator_time(indicators, kind), 4)
      if (indicators%is_rigid) then
         select case (kind)
         case (indicator_deflection)
            text = 'is RIGID, but under its loads and inertia it would deflect by '//percent//' of its length'//when
         case (indicator_compression)
            text = 'is compressed by '//value//" times its Euler load"//when//', and a RIGID beam does not buckle'
         case default
            text = 'is RIGID, but its loads change at '//value//' times its first bending frequency'//when//', and at rest it'// &
               & ' would deflect by '//as_text(100*indicator_value(indicators, indicator_deflection), 2)//' % of its length'
         end select
         return
      end if
      select case (kind)
      case (indicator_deflection)
         text = 'deflects by '//percent//' of its length in its frame'//when//', beyond the 10 % that '//fidelity(body)// &
            & ' is for'
      case (indicator_slope)
         text = 'has slopes up to '//value//' in its frame'//when//', beyond the 0.3 that one frame is for'
      case (indicator_rotation)
         text = 'rotates at '//value//' times its first frequency'//when//', and '//linear//' is not stiffened by the tension'// &
            & ' that rotation makes'
      case (indicator_compression)
         text = 'is compressed by '//value//" times its "//trim(merge('buckling load', 'Euler load   ', body%is_frame))//when
         if (body%reduced%geometric) text = text//', where K_G has nothing that ends the buckling'
         if (.not. body%reduced%geometric) text = text//', and '//linear//' does not buckle'
      case (indicator_geometric)
         text = 'deflects under axial forces whose work on the bending is '//percent//' of its elastic energy'//when// &
            & ', and '//linear//' leaves it out'
      case (indicator_stiffening)
         percent = 'about '//percent
         if (indicator_value(indicators, kind) > beyond) percent = 'more than '//as_text(100*beyond, 2)//' %'
         text = 'vibrates long enough for the work of axial forces on its bending, which '//linear//' leaves out, to shift the'// &
            & ' vibrations by '//percent//' of the largest deflection'//when
      case (indicator_axial)
         text = 'lacks axial force that changes its deflection by about '//percent//when
         if (indicators%held) then
            text = text//': its ends cannot approach each other as it bends'
         else
            text = text//': its axial functions cannot carry the tension'
         end if
      case (indicator_coarseness)
         text = 'has an axial force that varies within its '//as_text(indicators%elements)//' k_G elements, which'// &
            & ' changes its deflection by about '//percent//when
      case (indicator_residual)
         text = 'bends under the forces and couples of its joints and loads by '//percent//' of the energy in ways that its '// &
            & as_text(body%reduced%bending)//trim(merge('        ', ' bending', body%is_frame))//' coordinates cannot'//when
      case (indicator_lumping)
         text = 'has too few elements: with the mass in the nodes its deflection errs by about '//percent//when
      case (indicator_phase)
         percent = 'about '//percent
         if (indicator_value(indicators, kind) > beyond) percent = 'more than '//as_text(100*beyond, 2)//' %'
         text = 'has too few elements: with the mass in the nodes its vibrations are late by '//percent//' of their amplitude'//when
      case (indicator_false_damping)
         text = 'vibrates in rotation while it is bent'//when//': K_G leaves out the Coriolis force of its shortening, which'// &
            & ' damps or feeds the vibrations by about '//percent//' of the largest deflection'
      case (indicator_drift)
         text = 'vibrates long enough for the inertia of its shortening, which '// &
            & fidelity(body)//' leaves out, to shift the vibrations by about '//percent//' of the largest deflection'//when
      case (indicator_recoil)
         text = 'bends so quickly that the inertia of its shortening, which '//fidelity(body)//' leaves out, does work of '// &
            & percent//' of the energy of bending'//when
         if (body%reduced%geometric) text = text//": nothing else ends what axial vibrations feed to the bending of K_G"
      case (indicator_recoil_force)
         text = 'bends so quickly that the inertia of its shortening, which '//fidelity(body)//' leaves out, makes axial forces'// &
            & ' of '//percent//' of the largest so far'//when//': axial forces and reactions err by that'
         if (body%reduced%geometric) text = text//', and by many times as much where these feed axial vibrations'
      case (indicator_drawn)
         text = 'is drawn in by its bending, which '//fidelity(body)//' leaves out: '//trim(indicators%drawn_name)//' errs by '// &
            & percent//' of its largest '//trim(merge('value ', 'change', index('xyud', indicators%drawn_name(1:1)) == 0))//when
      case (indicator_buckling)
         text = 'is compressed by '//as_text(indicator_value(indicators, indicator_compression), 2)//' times its Euler load'// &
            & when//', which its functions take '//as_text(100*indicators%misfit, 2)//' % too large: they do not fit how its'// &
            & ' joints hold it'
      case (indicator_layer)
         text = 'is pulled so much that it bends near ends and loads over less length than its functions can follow'//when// &
            & ': '//lost_forces(layer_names, layer_errors(indicators), 'there ')
      case (indicator_sudden)
         text = 'vibrates under sudden or fast loads'//when//' as its coordinates do not: '// &
            & lost_forces(sudden_names, sudden_errors(indicators), '')
      case (indicator_membrane)
         text = 'lacks axial force that changes its deflection by about '//percent//when
         if (excess(indicators, body, indicator_reaction) > 1.0_wp) text = text//', and axial forces and reactions by about '// &
            & as_text(100*indicator_value(indicators, indicator_reaction), 2)//' % of the largest'
         text = text//held_apart
      case (indicator_reaction)
         text = 'lacks axial force of about '//percent//' of its largest axial force or load'//when//held_apart
      case (indicator_strain)
         text = 'is compressed by '//as_text(indicator_value(indicators, indicator_compression), 3)//' times its '// &
            & trim(merge('buckling load', 'Euler load   ', body%is_frame))//when//', where its deflection depends on how much'// &
            & ' shorter the compression makes it, which '//fidelity(body)//' leaves out: it errs by about '//percent
      case (indicator_elongation)
         text = 'is longer or shorter under its axial forces than its axial functions can follow, by '//percent// &
            & ' of the largest elongation or deflection'//when
         if (softens(indicators, body)) text = text//'; its buckling loads err by about as much, or by some times that'
         if (body%reduced%n == body%reduced%bending) text = 'has no axial coordinate: the change of its length by its axial'// &
            & ' forces, '//percent//' of the largest elongation or deflection, is left out'//when
      case default
         text = 'has large slopes under an axial force'//when//': the shortening that one frame leaves out does work of '// &
            & percent//' of the energy of bending'
         if (body%is_frame) text = 'is compressed by '//as_text(indicator_value(indicators, indicator_compression), 3)// &
            & ' times its buckling load'//when//', where its deflection depends on squares of its slopes, which '// &
            & fidelity(body)//' leaves out: it errs by about '//percent
      end select
   end function what_is_wrong

   !> Internal forces that are asked for and err in layers, each with its size.
   pure function lost_forces(names, errors, where) result(text)
      !> Names of the forces, their errors, and where these are, with a blank behind
      character(*), intent(in) :: names(:), where
      real(wp), intent(in) :: errors(:)
      character(:), allocatable :: text
      real(wp), parameter :: small = 0.02_wp
      integer :: i
      text = ''
      do i = 1, size(names)
         if (errors(i) < small .and. errors(i) < maxval(errors)) cycle
         if (text /= '') then
            text = text//', '//trim(names(i))//' by '
         else
            text = trim(names(i))//' '//where//'err by '
         end if
         if (errors(i) > beyond) text = text//'more than '//as_text(100*beyond, 2)//' %'
         if (.not. errors(i) > beyond) text = text//'about '//as_text(100*errors(i), 2)//' %'
      end do
   end function lost_forces

   !> What to use instead.
   function what_to_do(indicators, body, kind, over) result(text)
      type(body_indicators_type), intent(in) :: indicators
      type(body_type), intent(in) :: body
      integer, intent(in) :: kind
      !> How many times above its limit
      real(wp), intent(in) :: over
      character(:), allocatable :: text
      if (indicators%is_rigid) then
         text = 'let it be flexible: GEOMETRIC=EXACT'
         return
      end if
      if (body%is_frame) then
         text = cure_of_frame(body, kind, over)
         return
      end if
      select case (kind)
      case (indicator_layer)
         text = 'use GEOMETRIC=EXACT, more BENDING MODES and ELEMENTS, or the forces of the joints'
      case (indicator_sudden)
         text = 'use GEOMETRIC=EXACT, more BENDING MODES, or loads that grow in time'
      case (indicator_coarseness)
         text = 'use GEOMETRIC ELEMENTS='//as_text(ceiling(1.2_wp*indicators%elements*sqrt(over)))
         text = text//', or GEOMETRIC INTEGRAL=LINEAR, or GEOMETRIC=EXACT'
      case (indicator_residual, indicator_buckling)
         text = 'use GEOMETRIC=EXACT, more BENDING MODES, CORRECTIONS=YES, or a SUPPORT that is like its joints'
      case (indicator_lumping, indicator_phase)
         text = 'use ELEMENTS='//as_text(ceiling(1.2_wp*body%beam%elements*sqrt(over)))
      case default; text = 'use GEOMETRIC=EXACT'
      end select
   end function what_to_do

   !> The same of a frame.
   pure function cure_of_frame(body, kind, over) result(text)
      type(body_type), intent(in) :: body
      integer, intent(in) :: kind
      real(wp), intent(in) :: over
      character(:), allocatable :: text
      integer :: divisions
      divisions = maxval(body%mesh%first(2:) - body%mesh%first(:size(body%mesh%first) - 1))
      select case (kind)
      case (indicator_layer); text = 'use LARGE=YES, or more MODES and DIVISIONS'
      case (indicator_sudden); text = 'use more MODES, LARGE=YES, or loads that grow in time'
      case (indicator_axial)
         text = 'use CORRECTIONS=YES'
         if (body%frame_choice%accelerations) text = 'use more MODES, or LARGE=YES'
      case (indicator_residual)
         text = 'use CORRECTIONS=YES, more MODES, or a *BOUNDARY that is like its joints'
         if (body%frame_choice%accelerations) text = 'use more MODES, or LARGE=YES'
      case (indicator_lumping, indicator_phase); text = 'use DIVISIONS='//as_text(ceiling(1.2_wp*divisions*sqrt(over)))
      case (indicator_rotation, indicator_geometric, indicator_stiffening); text = 'use GEOMETRIC=K_G'
      case (indicator_compression)
         text = 'use LARGE=YES'
         if (.not. body%reduced%geometric) text = 'use GEOMETRIC=K_G'
      case default; text = 'use LARGE=YES'
      end select
   end function cure_of_frame

   !> Why no equilibrium is found, or the motion diverges, if a body is near or beyond what ends its model: it begins with ": ", or
   !> is empty.
   function likely_cause(indicators, model) result(text)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      !> Part of the buckling load, or of the first frequency, from which it counts
      real(wp), parameter :: near = 0.8_wp
      character(:), allocatable :: name
      real(wp) :: compression, rotation
      integer :: i
      text = ''
      name = ''
      do i = 1, size(indicators%bodies)
         if (indicators%bodies(i)%is_rigid .or. text /= '') cycle
         associate (body => indicators%bodies(i), of => model%bodies(indicators%bodies(i)%body))
            name = trim(merge('frame', 'beam ', of%is_frame))//" '"//of%name//"'"
            compression = indicator_value(body, indicator_compression)
            rotation = indicator_value(body, indicator_rotation)
            if (.not. of%reduced%geometric .and. rotation > near) then
               text = ': '//name//' is LINEAR, turns at '//as_text(rotation, 3)//' times its first frequency, and is not'// &
                  & ' stiffened by the tension that rotation makes; use GEOMETRIC='//trim(merge('K_G  ', 'EXACT', of%is_frame))
            else if (of%reduced%geometric .and. compression > near) then
               text = ': '//name//' is compressed by '//as_text(compression, 3)//' times its '// &
                  & trim(merge('buckling load', 'Euler load   ', of%is_frame))//' at t = '// &
                  & as_text(indicator_time(body, indicator_compression), 4)//', and K_G has no equilibrium beyond that; use '// &
                  & trim(merge('LARGE=YES      ', 'GEOMETRIC=EXACT', of%is_frame))
            end if
         end associate
      end do
   end function likely_cause

   pure function fidelity(body) result(name)
      type(body_type), intent(in) :: body
      character(:), allocatable :: name
      name = 'LINEAR'
      if (body%reduced%geometric) name = 'K_G'
   end function fidelity

   !> The indicators of all flexible bodies: /bodies/<name>/indicators, to h5py (indicators, 2): value and time, in the order of the
   !> attributes `names`, words, and `meanings`, lines, which are the same for all.
   subroutine record_indicators(indicators, model, history, error)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: path, names, meanings
      real(wp) :: values(2, indicator_count)
      integer :: i, k
      path = ''
      names = trim(indicator_names(1))
      meanings = trim(indicator_meanings(1))
      do k = 2, indicator_count
         names = names//' '//trim(indicator_names(k))
         meanings = meanings//newline//trim(indicator_meanings(k))
      end do
      do i = 1, size(indicators%bodies)
         associate (body => indicators%bodies(i))
            path = '/bodies/'//model%bodies(body%body)%name//'/indicators'
            do k = 1, indicator_count
               values(:, k) = [indicator_value(body, k), indicator_time(body, k)]
            end do
            call history%put_real(path, values, '1, '//model%units%time, &
               & 'largest value of each indicator of the range of the model, and its time', error)
            if (.not. allocated(error)) call history%put_attribute(path, 'names', names, error)
            if (.not. allocated(error)) call history%put_attribute(path, 'meanings', meanings, error)
            if (allocated(error)) return
         end associate
      end do
   end subroutine record_indicators

end module limber_monitor_model_ranges
