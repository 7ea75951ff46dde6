!> Settings of a study. The lists of *STUDY or their defaults, and the deck with the values of one setting in it. Floor: accuracy;
!> deck -> plan -> decks.
module limber_accuracy_study_plan
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: as_text, lowercase
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: keyword_options, split_values
   use limber_deck_reader, only: read_deck, beside
   use limber_deck_schema, only: option_spec_type
   use limber_deck_study_checks, only: study_beams, place_of, counts_by_kind
   use limber_model_analyses, only: single_dynamics
   implicit none
   private
   public :: plan_type, varied_type, setting_type, read_plan, variant, finest, levels, set_fine, control, all_integrators

   !> What can be varied
   integer, parameter, public :: axes = 5, axis_integrator = 1, axis_tolerance = 2, axis_modes = 3, axis_elements = 4, &
      & axis_fidelity = 5

   !> The values of one option
   type :: varied_type
      !> As in the keyword table: 'bending modes'
      character(:), allocatable :: name
      !> Block and option that it sets
      character(:), allocatable :: keyword, option
      !> Values as text, and as numbers: words have their places in the keyword table
      character(24), allocatable :: texts(:)
      real(wp), allocatable :: values(:)
   end type varied_type

   !> A point of the grid
   type :: setting_type
      !> Index into the values of each axis; 0: as in the deck
      integer :: level(axes) = 0
      !> Integrator and tolerance, and fixed step if it is not zero; those of the lists have their levels too
      character(24) :: integrator = ''
      real(wp) :: tolerance = 0.0_wp, step = 0.0_wp
   end type setting_type

   !> The whole study
   type :: plan_type
      !> As it was read
      character(:), allocatable :: path
      type(deck_type) :: deck
      !> Title of the deck, and unit of time
      character(:), allocatable :: heading, time_units
      type(varied_type) :: axis(axes)
      !> Whether the axis of tolerances is one of fixed steps
      logical :: has_steps = .false.
      !> Blocks of the beams that are varied, and whether none gets more than it has in the deck
      integer, allocatable :: beams(:)
      logical :: capped = .false.
      !> Channels that are compared: their names, and their indices among those of the deck
      character(64), allocatable :: names(:)
      integer, allocatable :: channels(:)
      !> Number of samples of a run
      integer :: samples = 0
      !> Options of *STUDY
      integer :: repeats = 3
      real(wp) :: aim = 0.01_wp, limit = 30.0_wp
      !> Name of the file to compare with; empty: limber makes the reference
      character(:), allocatable :: reference
   end type plan_type

contains

   !> Reads a deck and plans its study; the deck as it is must be good.
   subroutine read_plan(path, plan, error)
      character(*), intent(in) :: path
      type(plan_type), intent(out) :: plan
      !> Everything that is wrong with the deck or its *STUDY, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      integer :: block
      plan%path = path
      call read_deck(path, plan%deck, diagnostics)
      scene%deck = plan%deck
      call build_scene(scene, diagnostics, error)
      if (allocated(error)) return
      if (.not. scene%system%model%dynamics%wanted) then
         call raise(error, path//': nothing to study; add a *DYNAMICS block (limber help DYNAMICS)', status_deck)
         return
      else if (.not. single_dynamics(scene%system%model)) then
         call raise(error, path//': a study is of a single *DYNAMICS; remove the other analyses', status_deck)
         return
      else if (size(scene%system%model%channels) == 0) then
         call raise(error, path//': nothing to compare; add an *OUTPUT block (limber help OUTPUT)', status_deck)
         return
      end if
      plan%heading = scene%system%model%heading
      plan%time_units = scene%system%model%units%time
      plan%samples = scene%system%model%dynamics%outputs + 1
      plan%reference = ''
      block = plan%deck%find('STUDY')
      plan%beams = study_beams(plan%deck, block)
      call plan_axes(plan, block)
      if (block > 0) then
         plan%repeats = plan%deck%blocks(block)%integer('REPEATS')
         plan%aim = plan%deck%blocks(block)%real('ERROR')
         plan%limit = plan%deck%blocks(block)%real('LIMIT')
         if (plan%deck%blocks(block)%has('REFERENCE')) plan%reference = beside( &
            & plan%deck%source%files(plan%deck%blocks(block)%origin%file)%path, plan%deck%blocks(block)%text('REFERENCE'))
      end if
      call choose_channels(plan, block, scene)
   end subroutine read_plan

   !> The values of each axis.
   subroutine plan_axes(plan, block)
      type(plan_type), intent(inout) :: plan
      integer, intent(in) :: block
      logical :: exact
      plan%capped = block == 0
      call define(plan%axis(axis_integrator), 'integrators', 'DYNAMICS', 'INTEGRATOR')
      plan%has_steps = place_of(plan%deck, block, 'steps') > 0
      if (plan%has_steps) then
         call define(plan%axis(axis_tolerance), 'steps', 'DYNAMICS', 'FIXED STEP')
      else
         call define(plan%axis(axis_tolerance), 'tolerances', 'DYNAMICS', 'TOLERANCE')
      end if
      exact = are_exact(plan)
      if (exact) then
         call define(plan%axis(axis_modes), 'functions', 'BEAM', 'FUNCTIONS')
      else if (place_of(plan%deck, block, 'modes') > 0 .or. block == 0 .and. .not. by_kind(plan)) then
         call define(plan%axis(axis_modes), 'modes', 'BEAM', 'MODES')
      else
         call define(plan%axis(axis_modes), 'bending modes', 'BEAM', 'BENDING MODES')
      end if
      if (exact) then
         call define(plan%axis(axis_elements), 'strain functions', 'BEAM', 'STRAIN FUNCTIONS')
      else
         call define(plan%axis(axis_elements), 'geometric elements', 'BEAM', 'GEOMETRIC ELEMENTS')
      end if
      call define(plan%axis(axis_fidelity), 'fidelities', 'BEAM', 'GEOMETRIC')
      if (block == 0) then
         call fill_numbers(plan%axis(axis_modes), up_to([1, 2, 3], largest(plan, plan%axis(axis_modes)%option)))
         if (exact) then
            call fill_numbers(plan%axis(axis_elements), up_to([1], largest(plan, 'STRAIN FUNCTIONS')))
         else if (bends_geometrically(plan)) then
            call fill_numbers(plan%axis(axis_elements), few_elements(largest(plan, 'GEOMETRIC ELEMENTS')))
         end if
      end if
      call fill_given(plan, block)
      if (size(plan%axis(axis_integrator)%texts) == 0) call fill_words(plan%axis(axis_integrator))
      if (size(plan%axis(axis_tolerance)%texts) == 0) call fill_numbers(plan%axis(axis_tolerance), &
         & [1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp])
   end subroutine plan_axes

   !> An axis without values.
   pure subroutine define(axis, name, keyword, option)
      type(varied_type), intent(out) :: axis
      character(*), intent(in) :: name, keyword, option
      axis%name = name
      axis%keyword = keyword
      axis%option = option
      allocate (axis%texts(0), axis%values(0))
   end subroutine define

   !> Takes the lists of *STUDY.
   subroutine fill_given(plan, block)
      type(plan_type), intent(inout) :: plan
      integer, intent(in) :: block
      integer :: i, k, line
      do i = 1, axes
         line = place_of(plan%deck, block, plan%axis(i)%name)
         if (line == 0) cycle
         associate (fields => plan%deck%blocks(block)%lines(line)%fields)
            if (i == axis_integrator .or. i == axis_fidelity) then
               plan%axis(i)%texts = [character(24) :: (fields(k)%text, k=2, size(fields))]
               plan%axis(i)%values = [(real(rank_of(plan%axis(i), fields(k)%text), wp), k=2, size(fields))]
            else
               call fill_numbers(plan%axis(i), [(fields(k)%value, k=2, size(fields))])
            end if
         end associate
      end do
   end subroutine fill_given

   pure subroutine fill_numbers(axis, values)
      type(varied_type), intent(inout) :: axis
      real(wp), intent(in) :: values(:)
      integer :: k
      axis%values = values
      deallocate (axis%texts)
      allocate (axis%texts(size(values)))
      do k = 1, size(values)
         axis%texts(k) = as_text(values(k))
      end do
   end subroutine fill_numbers

   !> All words that the option of an axis takes.
   subroutine fill_words(axis)
      type(varied_type), intent(inout) :: axis
      integer :: k
      axis%texts = words_of(axis)
      axis%values = [(real(k, wp), k=1, size(axis%texts))]
   end subroutine fill_words

   !> The words that the option of an axis takes, in the order of the keyword table: fidelities become finer.
   function words_of(axis) result(words)
      type(varied_type), intent(in) :: axis
      character(24), allocatable :: words(:)
      type(option_spec_type), allocatable :: specs(:)
      allocate (specs, source=keyword_options(axis%keyword))
      specs = pack(specs, specs%name == axis%option)
      words = [character(24) :: split_values(trim(specs(1)%values))]
      ! Not one more integrator, but one of the others
      words = pack(words, words /= 'AUTO')
   end function words_of

   !> Place of a word among those that the option takes.
   integer function rank_of(axis, word) result(rank)
      type(varied_type), intent(in) :: axis
      character(*), intent(in) :: word
      character(24), allocatable :: words(:)
      allocate (words, source=words_of(axis))
      do rank = size(words), 1, -1
         if (words(rank) == word) return
      end do
   end function rank_of

   !> Those of some numbers that are below the last one, and the last one; none if there is no last one.
   pure function up_to(numbers, last) result(values)
      integer, intent(in) :: numbers(:), last
      real(wp), allocatable :: values(:)
      values = real([pack(numbers, numbers < last), pack([last], [last > 0])], wp)
   end function up_to

   !> Numbers of geometric elements up to a last one.
   pure function few_elements(last) result(values)
      integer, intent(in) :: last
      real(wp), allocatable :: values(:)
      if (last > 3) then
         values = up_to([3, 6], last)
      else
         values = up_to([1], last)
      end if
   end function few_elements

   !> Largest number of an option among the beams.
   pure integer function largest(plan, option)
      type(plan_type), intent(in) :: plan
      character(*), intent(in) :: option
      integer :: i
      largest = 0
      do i = 1, size(plan%beams)
         largest = max(largest, plan%deck%blocks(plan%beams(i))%integer(option))
      end do
   end function largest

   !> Whether all beams are exact ones.
   pure logical function are_exact(plan)
      type(plan_type), intent(in) :: plan
      integer :: i
      are_exact = all([(plan%deck%blocks(plan%beams(i))%word('GEOMETRIC') == 'EXACT', i=1, size(plan%beams))])
   end function are_exact

   !> Whether a beam has its modes counted by kind, bending and axial.
   pure logical function by_kind(plan)
      type(plan_type), intent(in) :: plan
      integer :: i
      by_kind = .false.
      do i = 1, size(plan%beams)
         by_kind = by_kind .or. counts_by_kind(plan%deck, plan%beams(i))
      end do
   end function by_kind

   !> Whether the geometric elements of a beam matter.
   pure logical function bends_geometrically(plan)
      type(plan_type), intent(in) :: plan
      integer :: i
      bends_geometrically = .false.
      do i = 1, size(plan%beams)
         bends_geometrically = bends_geometrically .or. plan%deck%blocks(plan%beams(i))%word('GEOMETRIC') == 'K_G'
      end do
   end function bends_geometrically

   !> The channels that are compared.
   subroutine choose_channels(plan, block, scene)
      type(plan_type), intent(inout) :: plan
      integer, intent(in) :: block
      type(scene_type), intent(in) :: scene
      integer :: line, i, k
      associate (channels => scene%system%model%channels)
         line = place_of(plan%deck, block, 'channels')
         if (line == 0) then
            plan%channels = [(i, i=1, size(channels))]
         else
            allocate (plan%channels(0))
            do i = 2, plan%deck%blocks(block)%lines(line)%count()
               do k = size(channels), 1, -1
                  if (lowercase(channels(k)%name) == plan%deck%blocks(block)%lines(line)%text(i)) exit
               end do
               if (k > 0) plan%channels = [plan%channels, k]
            end do
         end if
         allocate (plan%names(size(plan%channels)))
         do i = 1, size(plan%names)
            plan%names(i) = channels(plan%channels(i))%name
         end do
      end associate
   end subroutine choose_channels

   !> Number of values of an axis, at least the deck's own.
   pure integer function levels(axis)
      type(varied_type), intent(in) :: axis
      levels = max(1, size(axis%values))
   end function levels

   !> Level of the finest value of an axis: most modes or elements, highest fidelity, smallest tolerance.
   pure integer function finest(plan, which) result(level)
      type(plan_type), intent(in) :: plan
      integer, intent(in) :: which
      level = 0
      if (size(plan%axis(which)%values) == 0) return
      level = maxloc(plan%axis(which)%values, 1)
      if (which == axis_tolerance) level = minloc(plan%axis(which)%values, 1)
   end function finest

   !> Gives a setting an integrator and a tolerance that need not be in the lists.
   pure subroutine set_fine(setting, integrator, tolerance)
      type(setting_type), intent(inout) :: setting
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: tolerance
      setting%level([axis_integrator, axis_tolerance]) = 0
      setting%integrator = integrator
      setting%tolerance = tolerance
      setting%step = 0.0_wp
   end subroutine set_fine

   !> What a setting is controlled by: its tolerance, or its fixed step.
   elemental real(wp) function control(setting)
      type(setting_type), intent(in) :: setting
      control = setting%tolerance
      if (setting%step > 0.0_wp) control = setting%step
   end function control

   !> All integrators that a deck can ask for.
   function all_integrators(plan) result(names)
      type(plan_type), intent(in) :: plan
      character(24), allocatable :: names(:)
      names = words_of(plan%axis(axis_integrator))
   end function all_integrators

   !> The deck with the values of a setting, as a user would write them.
   subroutine variant(plan, setting, deck)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      type(deck_type), intent(out) :: deck
      integer :: block, i, level
      deck = plan%deck
      block = deck%find('DYNAMICS')
      call deck%set_option(block, 'INTEGRATOR', trim(setting%integrator))
      call deck%set_number(block, 'TOLERANCE', setting%tolerance)
      if (setting%step > 0.0_wp) call deck%set_number(block, 'FIXED STEP', setting%step)
      do i = 1, size(plan%beams)
         block = plan%beams(i)
         level = setting%level(axis_fidelity)
         if (level > 0) call deck%set_option(block, 'GEOMETRIC', trim(plan%axis(axis_fidelity)%texts(level)))
         call set_count(axis_modes)
         call set_count(axis_elements)
      end do

   contains

      !> A number of modes or elements.
      subroutine set_count(which)
         integer, intent(in) :: which
         real(wp) :: value
         associate (axis => plan%axis(which))
            if (setting%level(which) == 0) return
            value = axis%values(setting%level(which))
            if (plan%capped) value = min(value, real(deck%blocks(block)%integer(axis%option), wp))
            call deck%set_number(block, axis%option, value)
         end associate
      end subroutine set_count

   end subroutine variant

end module limber_accuracy_study_plan
