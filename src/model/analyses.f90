!> Analyses of a deck in their order, with options and start times. Floor: model.
module limber_model_analyses
   use limber_base_text, only: as_text
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_model, only: model_type, dynamics_type, analysis_step_type, step_kinematics, step_inverse, step_statics, &
      & step_modes, &
      & step_dynamics, leave_unstable, stay_unstable, stop_unstable, velocities_kept, velocities_none, velocities_of_deck
   implicit none
   private
   public :: add_analyses, single_dynamics, kind_names, title

   !> Keywords of the analyses, indexed by their kind
   character(16), parameter :: kind_names(5) = [character(16) :: 'KINEMATICS', 'INVERSE DYNAMICS', 'STATICS', 'MODES', 'DYNAMICS']

contains

   !> Reads all analyses. The first one becomes the active one. Start times that are not given are written into the deck.
   subroutine add_analyses(deck, model, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, count
      real(wp) :: now
      count = 0
      do i = 1, size(deck%blocks)
         if (step_kind(deck%blocks(i)%keyword) > 0) count = count + 1
      end do
      allocate (model%steps(count))
      count = 0
      now = 0.0_wp
      do i = 1, size(deck%blocks)
         if (step_kind(deck%blocks(i)%keyword) == 0) cycle
         count = count + 1
         if (deck%blocks(i)%knows('START')) then
            model%steps(count)%follows = .not. deck%blocks(i)%given('START')
            if (model%steps(count)%follows) call deck%set_number(i, 'START', now)
         end if
         if (.not. deck%blocks(i)%broken) call read_step(deck%blocks(i), i, model%steps(:count), diagnostics)
         model%steps(count)%dynamics%wanted = .true.
         if (model%steps(count)%kind == step_statics .or. model%steps(count)%kind == step_modes) then
            model%steps(count)%dynamics%start = now
            model%steps(count)%dynamics%end = now + model%steps(count)%dynamics%end
         end if
         now = model%steps(count)%dynamics%end
      end do
      if (count > 0) model%dynamics = model%steps(1)%dynamics
      if (model%accuracy%target > 0.0_wp .and. count > 0 .and. .not. single_dynamics(model)) call diagnostics%add( &
         & deck%blocks(deck%find('ACCURACY'))%origin_of('TARGET'), 'an accuracy can be asked of a single *DYNAMICS only', &
         & 'remove TARGET or the other analyses. Beams start in balance by *ASSEMBLY, INITIAL DEFLECTIONS=STATIC; bodies on'// &
         & ' springs start so at the X, Y, ANGLE that a run of *STATICS alone has found')
      if (model%accuracy%estimate .and. count > 0 .and. .not. single_dynamics(model)) call diagnostics%add( &
         & deck%blocks(deck%find('ACCURACY'))%origin_of('ESTIMATE'), 'errors are estimated of a single *DYNAMICS only', &
         & 'remove ESTIMATE or the other analyses. Beams start in balance by *ASSEMBLY, INITIAL DEFLECTIONS=STATIC; bodies on'// &
         & ' springs start so at the X, Y, ANGLE that a run of *STATICS alone has found')
   end subroutine add_analyses

   !> Whether the model has exactly one analysis, and it is *DYNAMICS.
   pure logical function single_dynamics(model)
      type(model_type), intent(in) :: model
      single_dynamics = .false.
      if (.not. allocated(model%steps)) return
      if (size(model%steps) == 1) single_dynamics = model%steps(1)%kind == step_dynamics
   end function single_dynamics

   !> Kind of analysis of a keyword; 0 if it is no analysis.
   pure integer function step_kind(keyword) result(kind)
      character(*), intent(in) :: keyword
      do kind = size(kind_names), 1, -1
         if (kind_names(kind) == keyword) return
      end do
   end function step_kind

   !> Reads the last of the steps.
   subroutine read_step(block, index, steps, diagnostics)
      type(block_type), intent(in) :: block
      !> Index of the block
      integer, intent(in) :: index
      type(analysis_step_type), intent(inout) :: steps(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      associate (step => steps(size(steps)))
         step%kind = step_kind(block%keyword)
         step%block = index
         step%name = step_name(block, steps)
         select case (step%kind)
         case (step_dynamics)
            call read_dynamics(block, step%dynamics, diagnostics)
            if (block%given('VELOCITIES') .and. size(steps) == 1) call diagnostics%add(block%origin_of('VELOCITIES'), &
               & 'VELOCITIES means nothing in the first analysis', 'leave it out: bodies begin with their VX, VY and SPIN')
            select case (block%word('VELOCITIES'))
            case ('REST'); step%velocities = velocities_none
            case ('DECK'); step%velocities = velocities_of_deck
            case default; step%velocities = velocities_kept
            end select
         case (step_statics); call read_statics(block, size(steps) == 1, step)
         case (step_modes)
            step%modes = block%integer('NUMBER')
            step%damped = block%yes('DAMPED')
         case default
            call read_times(block, step%dynamics, diagnostics)
            step%static_deflections = block%word('DEFLECTIONS') == 'STATIC'
         end select
         if (step%kind /= step_dynamics) step%dynamics%integrator = ''
         step%dynamics%reason = ''
      end associate
   end subroutine read_step

   !> NAME of the block, else a name from the keyword; from the second of its kind on with a number.
   pure function step_name(block, steps) result(name)
      type(block_type), intent(in) :: block
      type(analysis_step_type), intent(in) :: steps(:)
      character(:), allocatable :: name
      integer :: i, same
      if (block%has('NAME')) then
         name = block%name()
         return
      end if
      same = 0
      do i = 1, size(steps)
         if (steps(i)%kind == step_kind(block%keyword)) same = same + 1
      end do
      select case (step_kind(block%keyword))
      case (step_kinematics); name = 'kinematics'
      case (step_inverse); name = 'inverse_dynamics'
      case (step_statics); name = 'statics'
      case (step_modes); name = 'modes'
      case default; name = 'dynamics'
      end select
      if (same > 1) name = name//'_'//as_text(same)
   end function step_name

   !> Reads START, END and OUTPUTS.
   subroutine read_times(block, dynamics, diagnostics)
      type(block_type), intent(in) :: block
      type(dynamics_type), intent(inout) :: dynamics
      type(diagnostics_type), intent(inout) :: diagnostics
      dynamics%start = block%real('START')
      dynamics%end = block%real('END')
      dynamics%outputs = block%integer('OUTPUTS')
      if (dynamics%end <= dynamics%start) call diagnostics%add(block%origin_of('END'), &
         & 'END='//as_text(dynamics%end)//' is not later than START='//as_text(dynamics%start), 'give a later time')
   end subroutine read_times

   !> Reads a *STATICS. Its end is its PERIOD here; `add_analyses` adds the start.
   pure subroutine read_statics(block, is_first, step)
      type(block_type), intent(in) :: block
      !> Whether it is the first analysis
      logical, intent(in) :: is_first
      type(analysis_step_type), intent(inout) :: step
      step%dynamics%end = block%real('PERIOD')
      step%dynamics%outputs = block%integer('INCREMENTS')
      step%ramp = is_first
      if (block%has('RAMP')) step%ramp = block%yes('RAMP')
      select case (block%word('INSTABILITY'))
      case ('STAY'); step%instability = stay_unstable
      case ('STOP'); step%instability = stop_unstable
      case default; step%instability = leave_unstable
      end select
      step%rotation = block%real('ROTATION')
      step%centre = [block%real('CENTRE X'), block%real('CENTRE Y')]
   end subroutine read_statics

   !> Reads a *DYNAMICS.
   subroutine read_dynamics(block, dynamics, diagnostics)
      type(block_type), intent(in) :: block
      type(dynamics_type), intent(inout) :: dynamics
      type(diagnostics_type), intent(inout) :: diagnostics
      call read_times(block, dynamics, diagnostics)
      dynamics%tolerance = block%real('TOLERANCE')
      dynamics%integrator = block%word('INTEGRATOR')
      dynamics%spectral_radius = block%real('SPECTRAL RADIUS')
      dynamics%initial_step = block%real('INITIAL STEP')
      dynamics%maximum_step = block%real('MAXIMUM STEP')
      dynamics%fixed_step = block%real('FIXED STEP')
      dynamics%maximum_steps = block%integer('MAXIMUM STEPS')
      if (dynamics%spectral_radius > 1.0_wp) call diagnostics%add(block%origin_of('SPECTRAL RADIUS'), &
         & 'SPECTRAL RADIUS='//as_text(dynamics%spectral_radius)//' feeds vibrations', 'give a number from 0 to 1')
      if (dynamics%tolerance > 0.1_wp .or. dynamics%tolerance < 1.0e-13_wp) call diagnostics%add( &
         & block%origin_of('TOLERANCE'), 'TOLERANCE='//as_text(dynamics%tolerance)//' cannot be kept', &
         & 'give a value between 1e-13 and 0.1')
      if (dynamics%end > dynamics%start) call check_steps(block, dynamics, diagnostics)
   end subroutine read_dynamics

   !> Reports steps that do not fit each other or the analysis.
   subroutine check_steps(block, dynamics, diagnostics)
      type(block_type), intent(in) :: block
      type(dynamics_type), intent(in) :: dynamics
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: limits(2) = [character(12) :: 'INITIAL STEP', 'MAXIMUM STEP']
      character(:), allocatable :: span
      real(wp) :: longest
      integer :: i
      ! Round-off of computed steps
      longest = (dynamics%end - dynamics%start)*(1 + 1.0e-9_wp)
      span = 'from START='//as_text(dynamics%start)//' to END='//as_text(dynamics%end)
      if (block%given('FIXED STEP')) then
         if (dynamics%fixed_step > longest) call diagnostics%add(block%origin_of('FIXED STEP'), 'FIXED STEP='// &
            & as_text(dynamics%fixed_step)//' is longer than the analysis, '//span, 'give a shorter step')
         if (longest > 1.001_wp*dynamics%fixed_step*dynamics%maximum_steps) call diagnostics%add( &
            & block%origin_of('MAXIMUM STEPS'), as_text(dynamics%maximum_steps)//' steps of '//as_text(dynamics%fixed_step)// &
            & ' do not reach END='//as_text(dynamics%end), 'give more MAXIMUM STEPS, or a longer FIXED STEP')
         return
      end if
      if (block%given('INITIAL STEP') .and. block%given('MAXIMUM STEP') .and. &
         & dynamics%initial_step > dynamics%maximum_step) call diagnostics%add(block%origin_of('INITIAL STEP'), 'INITIAL STEP='// &
         & as_text(dynamics%initial_step)//' is longer than MAXIMUM STEP='//as_text(dynamics%maximum_step), 'give a shorter one')
      do i = 1, size(limits)
         if (.not. block%given(limits(i))) cycle
         if (block%real(limits(i)) > longest) call diagnostics%warn(block%origin_of(limits(i)), limits(i)//'='// &
            & as_text(block%real(limits(i)))//' is longer than the analysis, '//span, 'give a shorter one, or leave it out')
      end do
   end subroutine check_steps

   !> Keyword and name of an analysis, for messages.
   pure function title(step) result(text)
      type(analysis_step_type), intent(in) :: step
      character(:), allocatable :: text
      text = '*'//trim(kind_names(step%kind))//" '"//step%name//"'"
   end function title

end module limber_model_analyses
