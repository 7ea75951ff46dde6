!> Controls: blocks with states of their own, inputs that are expressions of the motion, and an output that laws and channels may
!> depend on: *CONTROL. Floor: elements. Source: doc/theory, section 5.21, eqs. (5.76)-(5.82).
module limber_elements_control
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_compile, only: compile
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_real, kind_positive, kind_nonnegative, kind_word, kind_law, form_fields
   use limber_model_controls, only: append_control, add_states
   use limber_model_element, only: element_type
   use limber_model_model, only: model_type, control_type, switch_type, most_slots
   implicit none
   private
   public :: control_element_type, control_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('CONTROL', many, form_fields, 1, many, &
      &    'A control: its states have rates of their own, and laws may depend on its output(name)')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('CONTROL', 'NAME', kind_name, 'controls', '', needed, 'name of the control'), &
      & option_spec_type('CONTROL', 'TYPE', kind_word, 'INTEGRATOR|LAG|SECOND ORDER|TRANSFER FUNCTION|STATE SPACE|PID|' &
      &    //'SATURATION|DEAD ZONE|HYSTERESIS|RATE LIMIT|HOLD|INPUT', '', needed, 'what it makes of its input'), &
      & option_spec_type('CONTROL', 'GAIN', kind_real, '', '', '1', &
      &    'factor of the input, but for TRANSFER FUNCTION, STATE SPACE, PID; HYSTERESIS: the output if it is on', &
      &    only='TYPE=INTEGRATOR|LAG|SECOND ORDER|SATURATION|DEAD ZONE|HYSTERESIS|RATE LIMIT|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'TIME CONSTANT', kind_positive, '', 's', '', &
      &    'LAG, RATE LIMIT: how slowly the output follows', only='TYPE=LAG|RATE LIMIT'), &
      & option_spec_type('CONTROL', 'FREQUENCY', kind_positive, '', 'rad/s', '', &
      &    'SECOND ORDER: angular frequency without damping', only='TYPE=SECOND ORDER'), &
      & option_spec_type('CONTROL', 'DAMPING', kind_nonnegative, '', '', '', 'SECOND ORDER: damping ratio', &
      &    only='TYPE=SECOND ORDER'), &
      & option_spec_type('CONTROL', 'KP', kind_real, '', '', '0', 'PID: gain of the input', only='TYPE=PID'), &
      & option_spec_type('CONTROL', 'KI', kind_real, '', '1/s', '0', 'PID: gain of its integral', only='TYPE=PID'), &
      & option_spec_type('CONTROL', 'KD', kind_real, '', 's', '0', 'PID: gain of its derivative', only='TYPE=PID'), &
      & option_spec_type('CONTROL', 'FILTER', kind_positive, '', 's', '', &
      &    'PID without PERIOD: time constant of the lag of the derivative, which starts at rest', only='TYPE=PID'), &
      & option_spec_type('CONTROL', 'LEAST', kind_real, '', '', '', &
      &    'PID, SATURATION, HOLD, INPUT: least output; DEAD ZONE, HYSTERESIS: limit below; RATE LIMIT: least rate', &
      &    only='TYPE=PID|SATURATION|DEAD ZONE|HYSTERESIS|RATE LIMIT|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'MOST', kind_real, '', '', '', &
      &    'PID, SATURATION, HOLD, INPUT: greatest output; DEAD ZONE, HYSTERESIS: limit above; RATE LIMIT: greatest rate', &
      &    only='TYPE=PID|SATURATION|DEAD ZONE|HYSTERESIS|RATE LIMIT|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'TRACKING', kind_positive, '', 's', '', &
      &    'PID with limits, without PERIOD: time in which the integral goes back; default: KP/KI', only='TYPE=PID'), &
      & option_spec_type('CONTROL', 'PERIOD', kind_positive, '', 's', '', &
      &    'HOLD, INPUT, PID: time between samples, which are at its multiples; a PID without it is continuous', &
      &    only='TYPE=PID|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'DELAY', kind_nonnegative, '', 's', '0', &
      &    'with PERIOD: time from a sample to the output that follows from it, at most PERIOD', only='TYPE=PID|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'INITIAL', kind_real, '', '', '0', 'its first output, without that of the input at once', &
      &    only='TYPE=INTEGRATOR|LAG|SECOND ORDER|PID|HYSTERESIS|RATE LIMIT|HOLD|INPUT'), &
      & option_spec_type('CONTROL', 'SCALE', kind_positive, '', '', '1e-3', &
      &    'errors of states count relative to their largest value so far, not below this size of the output', &
      &    only='TYPE=INTEGRATOR|LAG|SECOND ORDER|TRANSFER FUNCTION|STATE SPACE|PID|RATE LIMIT')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('CONTROL', 'input', kind_law, '', &
      &    'expression of t, motion, outputs; further lines: numbers, as the type says', repeated=.true.)]
   !> Words that TYPE takes
   type(word_spec_type), parameter :: words(*) = [ &
      & word_spec_type('CONTROL', 'INTEGRATOR', 'the integral of the input, from INITIAL'), &
      & word_spec_type('CONTROL', 'LAG', 'a lag of first order, GAIN/(TIME CONSTANT s + 1), from INITIAL'), &
      & word_spec_type('CONTROL', 'SECOND ORDER', 'a lag of second order, GAIN w^2/(s^2 + 2 DAMPING w s + w^2) with w = ' &
      &    //'FREQUENCY, from INITIAL at rest'), &
      & word_spec_type('CONTROL', 'TRANSFER FUNCTION', 'line 1: the input; line 2: coefficients of the numerator, of the highest' &
      &    //' power of s first; line 3: those of the denominator, of no less degree'), &
      & word_spec_type('CONTROL', 'STATE SPACE', 'line 1: the inputs; then a line for each state with its row of A and of B; last' &
      &    //' line: the row of C and of D: x'' = A x + B u, output C x + D u; x starts at zero'), &
      & word_spec_type('CONTROL', 'PID', 'KP e + KI * integral of e + KD * rate of e, the input being e; between LEAST and MOST,' &
      &    //' where the integral stops (PERIOD) or goes back (TRACKING)'), &
      & word_spec_type('CONTROL', 'SATURATION', 'GAIN times the input, but not below LEAST and not above MOST'), &
      & word_spec_type('CONTROL', 'DEAD ZONE', 'GAIN times the part of the input that is above MOST or below LEAST'), &
      & word_spec_type('CONTROL', 'HYSTERESIS', 'zero, or GAIN from when the input rises above MOST until it falls below LEAST;' &
      &    //' these turns are events. INITIAL, 0 or GAIN, if the input starts between them'), &
      & word_spec_type('CONTROL', 'RATE LIMIT', 'a lag of first order whose rate is not below LEAST and not above MOST'), &
      & word_spec_type('CONTROL', 'HOLD', 'GAIN times the input at the last sample, between LEAST and MOST; INITIAL before the' &
      &    //' first one'), &
      & word_spec_type('CONTROL', 'INPUT', 'as HOLD, but a program that steps the scene by the library may give the samples' &
      &    //' (doc/library.md); the data line counts until it does')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*CONTROL, NAME=pid, TYPE=PID, KP=400, KI=600, KD=40, LEAST=-30, MOST=30, PERIOD=0.005, DELAY=0.002', &
      & ' wanted - angle(arm)', &
      & '*CONTROL, NAME=motor, TYPE=LAG, TIME CONSTANT=0.004, SCALE=1', &
      & ' output(pid)', &
      & '*TORQUE, NAME=drive, BODY=arm', &
      & ' output(motor)']

   type, extends(element_type) :: control_element_type
   contains
      procedure :: read
   end type control_element_type

contains

   type(control_element_type) function control_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, words, example)
      element%round = 0
      element%switchable = .false.
   end function control_element

   !> Adds a control with the bodies that carry its states. What its inputs depend on is found when all objects are there.
   subroutine read(self, deck, index, model, diagnostics)
      class(control_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(control_type) :: control
      real(wp), allocatable :: scales(:)
      integer :: before
      before = diagnostics%count
      associate (block => deck%blocks(index))
         if (size(block%lines) == 0) return
         call check_options(block, diagnostics)
         call check_lines(block, diagnostics)
         if (diagnostics%count > before) return
         control%name = block%name()
         control%block = index
         call take_inputs(block, control)
         select case (block%word('TYPE'))
         case ('INTEGRATOR', 'LAG', 'RATE LIMIT'); call read_first_order(block, control, scales, diagnostics)
         case ('SECOND ORDER'); call read_second_order(block, control, scales, diagnostics)
         case ('TRANSFER FUNCTION'); call read_transfer_function(block, control, scales, diagnostics)
         case ('STATE SPACE'); call read_state_space(block, control, scales, diagnostics)
         case ('PID')
            if (block%given('PERIOD')) then
               call read_sampled(block, control, scales, diagnostics)
               control%gains = [block%real('KP'), block%real('KI')*control%period, block%real('KD')/control%period]
            else
               call read_pid(block, control, scales, diagnostics)
            end if
         case ('HOLD', 'INPUT')
            control%is_input = block%word('TYPE') == 'INPUT'
            call read_sampled(block, control, scales, diagnostics)
            control%gains = [block%real('GAIN'), 0.0_wp, 0.0_wp]
         case ('HYSTERESIS'); call read_hysteresis(block, model, control, scales, diagnostics)
         case ('SATURATION', 'DEAD ZONE'); call read_zone(block, control, scales, diagnostics)
         end select
      end associate
      if (diagnostics%count > before) return
      call append_control(model, control)
      call add_states(model, scales)
   end subroutine read

   !> Reports options that the type lacks, and values that do not fit each other.
   subroutine check_options(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: kind
      kind = block%word('TYPE')
      if (kind == 'LAG' .or. kind == 'RATE LIMIT') call need('TIME CONSTANT')
      if (kind == 'SECOND ORDER') call need('FREQUENCY')
      if (kind == 'SECOND ORDER') call need('DAMPING')
      if (kind == 'HOLD' .or. kind == 'INPUT') call need('PERIOD')
      if (kind == 'HYSTERESIS') call need('LEAST')
      if (kind == 'HYSTERESIS') call need('MOST')
      if (any(kind == [character(10) :: 'SATURATION', 'DEAD ZONE', 'RATE LIMIT']) .and. .not. (block%given('LEAST') .or. &
         & block%given('MOST'))) call diagnostics%add(block%origin_of('TYPE'), "control '"//block%name()//"' has no limits", &
         & 'add LEAST= or MOST=, or both')
      if (block%given('LEAST') .and. block%given('MOST')) then
         if (block%real('LEAST') > block%real('MOST')) call diagnostics%add(block%origin_of('LEAST'), &
            & 'LEAST='//as_text(block%real('LEAST'))//' is above MOST='//as_text(block%real('MOST')), 'exchange them')
      end if
      if (kind == 'HYSTERESIS' .and. abs(block%real('INITIAL')) > 0.0_wp .and. abs(block%real('INITIAL') - block%real('GAIN')) &
         & > 0.0_wp) call diagnostics%add(block%origin_of('INITIAL'), 'a hysteresis has the output 0 or '// &
         & as_text(block%real('GAIN'))//', its GAIN', 'give INITIAL=0 or INITIAL='//as_text(block%real('GAIN')))
      if (kind == 'RATE LIMIT') then
         if (block%given('LEAST') .and. block%real('LEAST') > 0.0_wp) call diagnostics%add(block%origin_of('LEAST'), &
            & 'the least rate is above zero: the output could never rest', 'give a rate that is not above zero')
         if (block%given('MOST') .and. block%real('MOST') < 0.0_wp) call diagnostics%add(block%origin_of('MOST'), &
            & 'the greatest rate is below zero: the output could never rest', 'give a rate that is not below zero')
      end if
      if (block%given('DELAY') .and. .not. block%given('PERIOD')) call diagnostics%add(block%origin_of('DELAY'), &
         & 'only a sampled output has a DELAY', 'add PERIOD=')
      if (block%given('DELAY') .and. block%given('PERIOD')) then
         if (block%real('DELAY') > block%real('PERIOD')) call diagnostics%add(block%origin_of('DELAY'), &
            & 'the DELAY is longer than the PERIOD', 'give one of '//as_text(block%real('PERIOD'))//' at most')
      end if
      if (kind == 'PID') call check_pid(block, diagnostics)

   contains

      !> Reports a missing option.
      subroutine need(option)
         character(*), intent(in) :: option
         if (.not. block%given(option)) call diagnostics%add(block%origin_of('TYPE'), 'controls of TYPE='//kind//' need '//option, &
            & 'add '//option//'=')
      end subroutine need

   end subroutine check_options

   !> Options of a PID beside each other.
   subroutine check_pid(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: sampled, derives, limited
      sampled = block%given('PERIOD')
      derives = abs(block%real('KD')) > 0.0_wp
      limited = block%given('LEAST') .or. block%given('MOST')
      if (.not. (abs(block%real('KP')) > 0.0_wp .or. abs(block%real('KI')) > 0.0_wp .or. derives)) call diagnostics%add( &
         & block%origin_of('TYPE'), "control '"//block%name()//"' does nothing", 'give one of KP, KI and KD at least')
      if (derives .and. .not. (sampled .or. block%given('FILTER'))) call diagnostics%add(block%origin_of('KD'), &
         & 'the derivative of a continuous PID needs a FILTER', 'add FILTER=, the time constant of its lag; or PERIOD=')
      if (block%given('FILTER') .and. sampled) call diagnostics%add(block%origin_of('FILTER'), &
         & 'the derivative of a sampled PID is the difference of two samples, without a FILTER', 'remove FILTER or PERIOD')
      if (block%given('FILTER') .and. .not. (derives .or. sampled)) call diagnostics%add(block%origin_of('FILTER'), &
         & 'FILTER is of the derivative, and KD is zero', 'remove FILTER')
      if (block%given('TRACKING') .and. (sampled .or. .not. limited)) call diagnostics%add(block%origin_of('TRACKING'), &
         & 'TRACKING is of a continuous PID with limits', 'remove it, or give LEAST or MOST')
      if (sampled .or. .not. limited .or. block%given('TRACKING') .or. .not. abs(block%real('KI')) > 0.0_wp) return
      if (.not. block%real('KP')/block%real('KI') > 0.0_wp) call diagnostics%add(block%origin_of('KI'), &
         & 'the limits of the output need TRACKING where KP/KI is no time', 'add TRACKING=')
   end subroutine check_pid

   !> Reports data lines that the type does not have, those that it lacks, and numbers that are none.
   subroutine check_lines(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: kind
      integer :: i, k
      kind = block%word('TYPE')
      associate (lines => block%lines)
         if (kind == 'TRANSFER FUNCTION') then
            if (size(lines) /= 3) call diagnostics%add(lines(size(lines))%origin, 'a transfer function has 3 data lines, not '// &
               & as_text(size(lines)), 'input, coefficients of the numerator, coefficients of the denominator')
         else if (kind == 'STATE SPACE') then
            call check_rows(block, diagnostics)
         else if (size(lines) > 1) then
            call diagnostics%add(lines(2)%origin, 'a control of TYPE='//kind//' has one data line, its input', 'remove this line')
         end if
         if (kind /= 'STATE SPACE' .and. lines(1)%count() > 1) call diagnostics%add(lines(1)%origin_of(2), &
            & 'a control of TYPE='//kind//' has one input', 'add up what it is to depend on')
         do i = 2, size(lines)
            do k = 1, lines(i)%count()
               if (.not. lines(i)%fields(k)%expression%is_constant()) call diagnostics%add(lines(i)%origin_of(k), &
                  & 'a coefficient of a control depends on time or motion', 'write a number')
            end do
         end do
      end associate
   end subroutine check_lines

   !> Numbers of a state space: as many lines and columns as its states and inputs ask for.
   subroutine check_rows(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: states, wide, i
      associate (lines => block%lines)
         states = size(lines) - 2
         if (states < 1) then
            call diagnostics%add(lines(size(lines))%origin, 'a state space has 3 data lines at least', &
               & 'inputs; for each state its row of A and of B; the row of C and of D')
            return
         end if
         wide = states + lines(1)%count()
         do i = 2, size(lines)
            if (lines(i)%count() /= wide) call diagnostics%add(lines(i)%origin, 'a line of this state space has '// &
               & as_text(wide)//' numbers, a number for each of its states, '//as_text(states)//', and inputs, '// &
               & as_text(lines(1)%count())//'; not '//as_text(lines(i)%count()), 'for each state a line with its row of A'// &
               & ' and of B, then the row of C and of D')
         end do
      end associate
   end subroutine check_rows

   !> The inputs of the first line.
   subroutine take_inputs(block, control)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      integer :: i
      allocate (control%inputs(block%lines(1)%count()))
      do i = 1, size(control%inputs)
         control%inputs(i) = block%lines(1)%fields(i)%expression
      end do
   end subroutine take_inputs

   !> A number of a data line after the first.
   real(wp) function number(block, line, field)
      type(block_type), intent(in) :: block
      integer, intent(in) :: line, field
      number = block%lines(line)%fields(field)%expression%constant_value()
   end function number

   !> INTEGRATOR, LAG, RATE LIMIT: eqs. (5.77), (5.82).
   subroutine read_first_order(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: rate
      call begin_states(block, control, 1, scales)
      control%first(1) = block%real('INITIAL')
      rate = value(block%real('GAIN'))//'*u1'
      if (block%word('TYPE') /= 'INTEGRATOR') rate = '('//rate//' - s1)/'//value(block%real('TIME CONSTANT'))
      if (block%word('TYPE') == 'RATE LIMIT') rate = limited(block, rate)
      call set_rate(block, control, 1, rate, diagnostics)
      call set_output(block, control, 's1', diagnostics)
   end subroutine read_first_order

   !> SECOND ORDER, eq. (5.77): the second state is the rate of the output.
   subroutine read_second_order(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: omega
      omega = block%real('FREQUENCY')
      call begin_states(block, control, 2, scales)
      scales(2) = omega*scales(1)
      control%first(1) = block%real('INITIAL')
      call set_rate(block, control, 1, 's2', diagnostics)
      call set_rate(block, control, 2, value(omega**2)//'*('//value(block%real('GAIN'))//'*u1 - s1) - '// &
         & value(2*block%real('DAMPING')*omega)//'*s2', diagnostics)
      call set_output(block, control, 's1', diagnostics)
   end subroutine read_second_order

   !> TRANSFER FUNCTION, eq. (5.78): the first state is the output without what follows the input at once.
   subroutine read_transfer_function(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), allocatable :: a(:), b(:)
      real(wp) :: pace
      integer :: n, i
      character(:), allocatable :: rate
      n = block%lines(3)%count() - 1
      if (block%lines(2)%count() > n + 1) then
         call diagnostics%add(block%lines(2)%origin, 'the numerator is of degree '//as_text(block%lines(2)%count() - 1)// &
            & ', the denominator of '//as_text(n), 'no output can be found of a numerator of higher degree')
         return
      end if
      if (n < 1 .or. .not. abs(number(block, 3, 1)) > 0.0_wp) then
         call diagnostics%add(block%lines(3)%origin_of(1), 'the denominator begins with a coefficient that is zero, or has no'// &
            & ' power of s', 'give the coefficient of its highest power first; a mere factor is GAIN of other types')
         return
      end if
      allocate (a(0:n), b(0:n))
      b = 0.0_wp
      do i = 0, n
         a(i) = number(block, 3, i + 1)/number(block, 3, 1)
      end do
      do i = 1, block%lines(2)%count()
         b(n + i - block%lines(2)%count()) = number(block, 2, i)/number(block, 3, 1)
      end do
      pace = maxval([(abs(a(i))**(1.0_wp/i), i=1, n)])
      if (.not. pace > 0.0_wp) pace = 1.0_wp
      call begin_states(block, control, n, scales)
      do i = 1, n
         scales(i) = scales(i)*pace**(i - 1)
         rate = ''
         if (i < n) rate = 's'//as_text(i + 1)
         call add_term(rate, -a(i), 's1')
         call add_term(rate, b(i) - a(i)*b(0), 'u1')
         call set_rate(block, control, i, rate, diagnostics)
      end do
      rate = 's1'
      call add_term(rate, b(0), 'u1')
      call set_output(block, control, rate, diagnostics)
   end subroutine read_transfer_function

   !> STATE SPACE, eq. (5.76).
   subroutine read_state_space(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: sum
      integer :: i, k, n
      n = size(block%lines) - 2
      if (n + block%lines(1)%count() > most_slots) then
         call diagnostics%add(block%lines(1)%origin, 'a state space of '//as_text(n)//' states and '// &
            & as_text(block%lines(1)%count())//' inputs', 'states and inputs together are at most '//as_text(most_slots))
         return
      end if
      call begin_states(block, control, n, scales)
      do i = 1, n + 1
         sum = ''
         do k = 1, n
            call add_term(sum, number(block, i + 1, k), 's'//as_text(k))
         end do
         do k = 1, size(control%inputs)
            call add_term(sum, number(block, i + 1, n + k), 'u'//as_text(k))
         end do
         if (i <= n) call set_rate(block, control, i, sum, diagnostics)
         if (i > n) call set_output(block, control, sum, diagnostics)
      end do
   end subroutine read_state_space

   !> A continuous PID, eqs. (5.79), (5.80). Its states are the integral, if KI is not zero, and what the lag of the derivative
   !> holds back, if KD is not zero, both in the unit of the output.
   subroutine read_pid(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: sum, integral, held, rate
      real(wp) :: ki, kd, filter, tracking
      integer :: n
      ki = block%real('KI')
      kd = block%real('KD')
      n = count([abs(ki) > 0.0_wp, abs(kd) > 0.0_wp])
      call begin_states(block, control, n, scales)
      integral = value(block%real('INITIAL'))
      held = ''
      if (abs(ki) > 0.0_wp) integral = 's1'
      sum = integral
      call add_term(sum, block%real('KP'), 'u1')
      if (abs(kd) > 0.0_wp) then
         filter = block%real('FILTER')
         held = 's'//as_text(n)
         call add_term(sum, kd/filter, 'u1')
         sum = sum//' - '//held
         rate = '('//value(kd/filter)//'*u1 - '//held//')/'//value(filter)
         control%first_gain(n) = kd/filter
         call set_rate(block, control, n, rate, diagnostics)
      end if
      if (abs(ki) > 0.0_wp) then
         control%first(1) = block%real('INITIAL')
         rate = value(ki)//'*u1'
         if (block%given('LEAST') .or. block%given('MOST')) then
            tracking = block%real('KP')/ki
            if (block%given('TRACKING')) tracking = block%real('TRACKING')
            rate = rate//' + ('//limited(block, sum)//' - ('//sum//'))/'//value(tracking)
         end if
         call set_rate(block, control, 1, rate, diagnostics)
      end if
      call set_output(block, control, limited(block, sum), diagnostics)
   end subroutine read_pid

   !> A sampled PID or hold, eq. (5.81). Its states have no rates: output; output that follows it; integral; last input; whether
   !> there is a last input.
   subroutine read_sampled(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      call begin_states(block, control, 5, scales)
      control%first(1:2) = block%real('INITIAL')
      if (block%word('TYPE') == 'PID') control%first(3) = block%real('INITIAL')
      control%period = block%real('PERIOD')
      control%delay = block%real('DELAY')
      if (block%given('LEAST')) control%least = block%real('LEAST')
      if (block%given('MOST')) control%most = block%real('MOST')
      call set_output(block, control, 's1', diagnostics)
   end subroutine read_sampled

   !> HYSTERESIS: its state is the output, which follows a switch of its own.
   subroutine read_hysteresis(block, model, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(switch_type) :: switch
      call begin_states(block, control, 1, scales)
      control%first(1) = block%real('INITIAL')
      control%gains(1) = block%real('GAIN')
      control%least = block%real('LEAST')
      control%most = block%real('MOST')
      switch%name = control%name//' on'
      switch%on = abs(block%real('INITIAL')) > 0.0_wp
      model%switches = [model%switches, switch]
      control%switch = size(model%switches)
      call compile_text(block, control, 'u1 - '//value(control%most), control%above, diagnostics)
      call compile_text(block, control, 'u1 - '//value(control%least), control%below, diagnostics)
      call set_output(block, control, 's1', diagnostics)
   end subroutine read_hysteresis

   !> SATURATION and DEAD ZONE, eq. (5.82).
   subroutine read_zone(block, control, scales, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      real(wp), allocatable, intent(out) :: scales(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: text
      call begin_states(block, control, 0, scales)
      if (block%word('TYPE') == 'SATURATION') then
         text = limited(block, value(block%real('GAIN'))//'*u1')
      else
         text = ''
         if (block%given('MOST')) text = 'max(0, u1 - '//value(block%real('MOST'))//')'
         if (block%given('LEAST')) text = text//' + min(0, u1 - '//value(block%real('LEAST'))//')'
         text = value(block%real('GAIN'))//'*('//text//')'
      end if
      call set_output(block, control, text, diagnostics)
   end subroutine read_zone

   !> Room for states that start at zero and have no rates.
   subroutine begin_states(block, control, n, scales)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      !> Their number
      integer, intent(in) :: n
      !> Sizes below which errors do not shrink (n)
      real(wp), allocatable, intent(out) :: scales(:)
      allocate (control%rates(n), control%first(n), control%first_gain(n), scales(n))
      control%first = 0.0_wp
      control%first_gain = 0.0_wp
      scales = block%real('SCALE')
   end subroutine begin_states

   !> Compiles the rate of a state.
   subroutine set_rate(block, control, state, text, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      integer, intent(in) :: state
      character(*), intent(in) :: text
      type(diagnostics_type), intent(inout) :: diagnostics
      call compile_text(block, control, text, control%rates(state), diagnostics)
   end subroutine set_rate

   !> Compiles the output.
   subroutine set_output(block, control, text, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(inout) :: control
      character(*), intent(in) :: text
      type(diagnostics_type), intent(inout) :: diagnostics
      call compile_text(block, control, text, control%output, diagnostics)
   end subroutine set_output

   !> Compiles a function of inputs u1, u2, ... and states s1, s2, ...; without a text it is zero.
   subroutine compile_text(block, control, text, law, diagnostics)
      type(block_type), intent(in) :: block
      type(control_type), intent(in) :: control
      character(*), intent(in) :: text
      type(expression_type), intent(out) :: law
      type(diagnostics_type), intent(inout) :: diagnostics
      type(parameter_list_type) :: none
      character(8) :: variables(size(control%inputs) + size(control%rates))
      logical :: ok
      integer :: i, m
      m = size(control%inputs)
      do i = 1, m
         variables(i) = 'u'//as_text(i)
      end do
      do i = 1, size(control%rates)
         variables(m + i) = 's'//as_text(i)
      end do
      if (text == '') then
         call compile('0', block%origin, none, law, ok, diagnostics, variables=variables)
      else
         call compile(text, block%origin, none, law, ok, diagnostics, variables=variables)
      end if
   end subroutine compile_text

   !> A text between the limits of a block.
   function limited(block, text) result(within)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: text
      character(:), allocatable :: within
      within = '('//text//')'
      if (block%given('LEAST')) within = 'max('//value(block%real('LEAST'))//', '//within//')'
      if (block%given('MOST')) within = 'min('//value(block%real('MOST'))//', '//within//')'
   end function limited

   !> Adds a term to a sum, unless its factor is zero.
   subroutine add_term(sum, factor, variable)
      character(:), allocatable, intent(inout) :: sum
      real(wp), intent(in) :: factor
      character(*), intent(in) :: variable
      if (.not. abs(factor) > 0.0_wp) return
      if (sum /= '') sum = sum//' + '
      sum = sum//value(factor)//'*'//variable
   end subroutine add_term

   !> A number as a factor.
   pure function value(number) result(text)
      real(wp), intent(in) :: number
      character(:), allocatable :: text
      text = as_text(number)
      if (number < 0.0_wp) text = '('//text//')'
   end function value

end module limber_elements_control
