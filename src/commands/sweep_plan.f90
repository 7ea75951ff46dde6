!> Values of a sweep row by row. The values of parameters row by row, from *SWEEP and the command line. Floor: commands; deck ->
!> plan.
module limber_commands_sweep_plan
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: longest_path
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text, lowercase, newline
   use limber_base_version, only: version, commit
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_lexer, only: part_type
   use limber_deck_origin, only: origin_type
   use limber_deck_parameters, only: override_type, name_length
   use limber_deck_reader, only: read_deck
   use limber_deck_sweep_checks, only: most_rows
   use limber_deck_sweep_table, only: read_table, read_value
   use limber_model_run_scalars, only: add_usual_scalars
   implicit none
   private
   public :: sweep_type, swept_type, plan_sweep, read_setting, row_overrides

   !> Parameters that change together
   type :: swept_type
      character(name_length), allocatable :: names(:)
      !> Values (names, count); of a range that is to be sampled its first and last
      real(wp), allocatable :: values(:, :)
      logical :: is_range = .false.
   end type swept_type

   !> A sweep
   type :: sweep_type
      !> Path of the deck; folder of the rows, for which a summary is made
      character(:), allocatable :: path
      character(name_length), allocatable :: names(:)
      !> Values of the parameters (names, rows), and what a row is known by: all that its results follow from
      real(wp), allocatable :: values(:, :)
      character(16), allocatable :: keys(:)
      !> Names, meanings and units of the scalars that each row gives
      character(name_length), allocatable :: scalars(:)
      character(200), allocatable :: meanings(:)
      character(40), allocatable :: units(:)
      !> Whether histories are kept, and CPU time after which a run is given up [s]
      logical :: keep = .false.
      real(wp) :: limit = huge(1.0_wp)
      !> Its files, those that it includes and reads among them, padded with blanks
      character(longest_path), allocatable :: sources(:)
      !> The deck
      type(deck_type) :: deck
   end type sweep_type

contains

   !> Makes the plan.
   subroutine plan_sweep(path, settings, sweep, error)
      character(*), intent(in) :: path
      !> Axes of the command line, which take the place of those of the deck
      type(swept_type), intent(in) :: settings(:)
      type(sweep_type), intent(out) :: sweep
      !> The deck, or the sweep, cannot be used; status 2
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(swept_type), allocatable :: axes(:)
      integer :: i
      call read_scene(path, scene, error)
      if (allocated(error)) return
      sweep%path = path
      call read_axes(scene%deck, settings, sweep, axes, diagnostics)
      if (diagnostics%count == 0) call make_rows(scene%deck, axes, sweep, diagnostics)
      if (diagnostics%count == 0) call check_names(path, sweep, diagnostics)
      if (diagnostics%count > 0) then
         call raise(error, diagnostics%render(scene%deck%source), status_deck)
         return
      end if
      call add_usual_scalars(scene%system%model)
      associate (scalars => scene%system%model%scalars)
         do i = 1, size(scalars)
            if (any(sweep%names == scalars(i)%name)) call diagnostics%add(origin_type(file=1), "the swept parameter '"// &
               & scalars(i)%name//"' has the name of a scalar", 'give one of the two another name')
         end do
         if (diagnostics%count > 0) then
            call raise(error, diagnostics%render(scene%deck%source), status_deck)
            return
         end if
         allocate (sweep%scalars(size(scalars)), sweep%meanings(size(scalars)), sweep%units(size(scalars)))
         do i = 1, size(scalars)
            sweep%scalars(i) = scalars(i)%name
            sweep%meanings(i) = scalars(i)%long_name
            sweep%units(i) = scalars(i)%units
         end do
      end associate
      associate (source => scene%deck%source)
         allocate (sweep%sources, source=source%paths())
      end associate
      sweep%deck = scene%deck
      call make_keys(scene%deck, sweep)
   end subroutine plan_sweep

   !> The axes of the deck and of the command line.
   subroutine read_axes(deck, settings, sweep, axes, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(swept_type), intent(in) :: settings(:)
      type(sweep_type), intent(inout) :: sweep
      type(swept_type), allocatable, intent(out) :: axes(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(swept_type), allocatable :: found(:)
      type(swept_type) :: table
      type(part_type), allocatable :: columns(:)
      real(wp), allocatable :: values(:, :)
      integer :: block, i, count
      block = deck%find('SWEEP')
      count = 0
      if (block > 0) count = size(deck%blocks(block)%lines)
      allocate (found(count + 1 + size(settings)))
      count = 0
      if (block > 0) then
         sweep%keep = deck%blocks(block)%yes('KEEP')
         if (deck%blocks(block)%has('LIMIT')) sweep%limit = deck%blocks(block)%real('LIMIT')
         do i = 1, size(deck%blocks(block)%lines)
            call read_axis(deck%blocks(block), i, table, diagnostics)
            if (is_set(table, settings)) cycle
            count = count + 1
            found(count) = table
         end do
         if (deck%blocks(block)%text('FILE') /= '') then
            call read_table(deck, block, columns, values, diagnostics)
            count = count + 1
            allocate (found(count)%names(size(columns)))
            do i = 1, size(columns)
               found(count)%names(i) = columns(i)%text
            end do
            call move_alloc(values, found(count)%values)
         end if
      end if
      do i = 1, size(settings)
         count = count + 1
         found(count) = settings(i)
      end do
      if (count == 0 .and. diagnostics%count == 0) call diagnostics%add(origin_type(file=1), 'nothing is swept', &
         & 'add *SWEEP with lines of parameters and values, or --set name=first:last:count')
      allocate (axes(count), source=found(:count))
   end subroutine read_axes

   !> Whether the command line sets the parameter of an axis.
   pure logical function is_set(axis, settings)
      type(swept_type), intent(in) :: axis
      type(swept_type), intent(in) :: settings(:)
      integer :: i
      is_set = .false.
      do i = 1, size(settings)
         is_set = is_set .or. settings(i)%names(1) == axis%names(1)
      end do
   end function is_set

   !> A data line of *SWEEP.
   subroutine read_axis(block, line, axis, diagnostics)
      type(block_type), intent(in) :: block
      integer, intent(in) :: line
      type(swept_type), intent(out) :: axis
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: text
      logical :: ok
      integer :: i
      text = ''
      associate (fields => block%lines(line)%fields)
         do i = 2, size(fields)
            text = text//','//fields(i)%text
         end do
         call read_setting(fields(1)%text//'='//text(2:), axis, ok)
         if (.not. ok) call diagnostics%add(fields(2)%origin, 'a range stands alone in its line, with at least two values', &
            & 'write numbers, or first:last:count')
      end associate
   end subroutine read_axis

   !> `name=number,number,...`, `name=first:last:count`, or `name=first:last`.
   subroutine read_setting(text, axis, ok)
      character(*), intent(in) :: text
      type(swept_type), intent(out) :: axis
      logical, intent(out) :: ok
      integer :: equals, i, count, first
      real(wp) :: ends(3)
      equals = index(text, '=')
      ok = equals > 1 .and. equals < len_trim(text)
      allocate (axis%names(1))
      axis%names(1) = lowercase(trim(adjustl(text(:max(0, equals - 1)))))
      if (.not. ok) return
      associate (values => text(equals + 1:))
         count = 1
         do i = 1, len(values)
            if (scan(values(i:i), ',:') > 0) count = count + 1
         end do
         if (index(values, ':') > 0) then
            ok = index(values, ',') == 0 .and. count <= 3
            if (.not. ok) return
            ends(3) = 2.0_wp
            first = 1
            do i = 1, count
               equals = index(values(first:)//':', ':')
               call read_value(values(first:first + equals - 2), ends(i), ok)
               if (.not. ok) return
               first = first + equals
            end do
            ok = abs(ends(3) - anint(ends(3))) <= 0.0_wp .and. ends(3) >= 2.0_wp .and. ends(3) <= most_rows
            if (.not. ok) return
            axis%is_range = count == 2
            count = nint(ends(3))
            allocate (axis%values(1, count))
            axis%values(1, :) = [(ends(1) + (ends(2) - ends(1))*(real(i, wp)/(count - 1)), i=0, count - 1)]
            axis%values(1, count) = ends(2)
         else
            allocate (axis%values(1, count))
            first = 1
            do i = 1, count
               equals = index(values(first:)//',', ',')
               call read_value(values(first:first + equals - 2), axis%values(1, i), ok)
               if (.not. ok) return
               first = first + equals
            end do
         end if
         if (ok) ok = all(abs(axis%values) <= huge(1.0_wp))
      end associate
   end subroutine read_setting

   !> All rows of values.
   subroutine make_rows(deck, axes, sweep, diagnostics)
      type(deck_type), intent(in) :: deck
      type(swept_type), intent(in) :: axes(:)
      type(sweep_type), intent(inout) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: method
      integer, allocatable :: counts(:)
      integer :: i, k, rows, row, first, rest, place, block
      real(wp) :: wanted
      block = deck%find('SWEEP')
      method = 'GRID'
      if (block > 0) method = deck%blocks(block)%word('METHOD')
      allocate (counts(size(axes)))
      do i = 1, size(axes)
         counts(i) = size(axes(i)%values, 2)
      end do
      wanted = product(real(counts, wp))
      if (method == 'PAIRS') wanted = counts(1)
      if (method == 'LATIN HYPERCUBE') wanted = deck%blocks(block)%integer('SAMPLES')
      if (wanted > most_rows) call diagnostics%add(origin_type(file=1), 'the sweep has '//as_text(wanted, 3)//' runs', &
         & 'at most '//as_text(most_rows))
      if (method == 'PAIRS' .and. any(counts /= counts(1))) call diagnostics%add(deck%blocks(block)%origin, &
         & 'METHOD=PAIRS needs as many values of one parameter as of another')
      do i = 1, size(axes)
         if (axes(i)%is_range .neqv. method == 'LATIN HYPERCUBE') call diagnostics%add(origin_type(file=1), &
            & "parameter '"//trim(axes(i)%names(1))//"': METHOD="//method//' cannot use these values', &
            & 'first:last for LATIN HYPERCUBE; else numbers, or first:last:count')
      end do
      if (diagnostics%count > 0) return
      rows = nint(wanted)
      allocate (sweep%names(sum([(size(axes(i)%names), i=1, size(axes))])))
      allocate (sweep%values(size(sweep%names), rows))
      first = 0
      do i = 1, size(axes)
         associate (names => axes(i)%names)
            sweep%names(first + 1:first + size(names)) = names
            do row = 1, rows
               place = row
               if (method == 'GRID') then
                  rest = row - 1
                  do k = size(axes), i + 1, -1
                     rest = rest/counts(k)
                  end do
                  place = mod(rest, counts(i)) + 1
               end if
               if (method /= 'LATIN HYPERCUBE') sweep%values(first + 1:first + size(names), row) = axes(i)%values(:, place)
            end do
            if (method == 'LATIN HYPERCUBE') call sample(axes(i)%values(1, 1), axes(i)%values(1, 2), &
               & deck%blocks(block)%integer('SEED') + 7919*(i - 1), sweep%values(first + 1, :))
            first = first + size(names)
         end associate
      end do
   end subroutine make_rows

   !> One value in each of as many equal parts of a range, in an order by chance.
   subroutine sample(first, last, seed, values)
      real(wp), intent(in) :: first, last
      integer, intent(in) :: seed
      real(wp), intent(out) :: values(:)
      integer(long) :: state
      integer :: i, k, n
      real(wp) :: keep
      n = size(values)
      state = mod(int(seed, long)*48271_long, 2147483647_long)
      do i = 1, 20
         call step()
      end do
      do i = 1, n
         call step()
         values(i) = first + (last - first)*((i - 1) + real(state, wp)/2147483647.0_wp)/n
      end do
      do i = n, 2, -1
         call step()
         k = 1 + int(mod(state, int(i, long)))
         keep = values(k)
         values(k) = values(i)
         values(i) = keep
      end do

   contains

      !> The minimal standard generator of Park and Miller.
      subroutine step()
         state = mod(state*16807_long, 2147483647_long)
      end subroutine step

   end subroutine sample

   !> Complains of parameters that the deck does not have, or that are swept twice.
   subroutine check_names(path, sweep, diagnostics)
      character(*), intent(in) :: path
      type(sweep_type), intent(in) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      type(deck_type) :: deck
      type(diagnostics_type) :: found
      integer :: i
      do i = 2, size(sweep%names)
         if (any(sweep%names(:i - 1) == sweep%names(i))) call diagnostics%add(origin_type(file=1), "the parameter '"// &
            & trim(sweep%names(i))//"' is swept twice")
      end do
      call read_deck(path, deck, found, row_overrides(sweep, 1))
      do i = 1, size(deck%parameters%overrides)
         if (.not. deck%parameters%overrides(i)%used) call diagnostics%add(origin_type(file=1), "the deck has no parameter '"// &
            & trim(deck%parameters%overrides(i)%name)//"' to be swept", 'define it: *PARAMETER, then name = value')
      end do
   end subroutine check_names

   !> Values of a row, for the deck.
   pure function row_overrides(sweep, row) result(overrides)
      type(sweep_type), intent(in) :: sweep
      integer, intent(in) :: row
      type(override_type), allocatable :: overrides(:)
      allocate (overrides(size(sweep%names)))
      overrides%name = sweep%names
      overrides%value = sweep%values(:, row)
   end function row_overrides

   !> What each row is known by: 16 hexadecimal digits of the program, the effective deck without its *SWEEP, and the row's values.
   subroutine make_keys(deck, sweep)
      type(deck_type), intent(in) :: deck
      type(sweep_type), intent(inout) :: sweep
      integer(long) :: base(2), hash(2)
      integer :: i, k
      base = [5381_long, 52711_long]
      call mix(version//' '//commit//newline//without_sweep(effective_deck(deck)), base)
      allocate (sweep%keys(size(sweep%values, 2)))
      do i = 1, size(sweep%keys)
         hash = base
         do k = 1, size(sweep%names)
            call mix(trim(sweep%names(k))//'='//as_text(sweep%values(k, i))//';', hash)
         end do
         write (sweep%keys(i), '(2z8.8)') hash
      end do
   end subroutine make_keys

   !> An effective deck without what it says of a sweep, which may grow.
   pure function without_sweep(text) result(rest)
      character(*), intent(in) :: text
      character(:), allocatable :: rest
      integer :: first, last
      rest = text
      first = index(newline//text, newline//'*SWEEP')
      if (first == 0) return
      last = index(text(first + 1:), newline//'*')
      if (last == 0) last = len(text) - first
      rest = text(:first - 1)//text(first + last + 1:)
   end function without_sweep

   !> Adds a text to two polynomial hashes modulo primes below 2^31.
   pure subroutine mix(text, hash)
      character(*), intent(in) :: text
      integer(long), intent(inout) :: hash(2)
      integer :: i
      do i = 1, len(text)
         hash(1) = mod(hash(1)*1000003_long + iachar(text(i:i)) + 1, 2147483647_long)
         hash(2) = mod(hash(2)*69069_long + iachar(text(i:i)) + 1, 2147483629_long)
      end do
   end subroutine mix

end module limber_commands_sweep_plan
