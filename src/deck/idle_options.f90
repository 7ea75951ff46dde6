!> Options without effect beside the others of their block: each row of the keyword table says when its option has one. Floor: deck.
module limber_deck_idle_options
   use limber_base_kinds, only: wp
   use limber_deck_content, only: block_type, option_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_deck_keywords, only: contains_value, alternatives, keyword_options
   use limber_deck_schema, only: option_spec_type, needed, kind_real, kind_positive, kind_nonnegative, kind_count, kind_counting, &
      & kind_yes
   implicit none
   private
   public :: is_idle, check_idle, gives_default

contains

   !> Whether an option has no effect in a block, by what the block says beside it.
   pure logical function is_idle(block, spec)
      type(block_type), intent(in) :: block
      !> Row of the option
      type(option_spec_type), intent(in) :: spec
      integer :: equals
      is_idle = .false.
      if (spec%only == '') return
      equals = index(spec%only, '=')
      if (spec%only(1:1) == '-') then
         is_idle = block%given(trim(spec%only(2:)))
      else if (equals == 0) then
         is_idle = .not. block%given(trim(spec%only))
      else if (block%has(spec%only(:equals - 1))) then
         ! A refused word is an error of its own
         is_idle = .not. contains_value(spec%only(equals + 1:), block%word(spec%only(:equals - 1)))
      end if
   end function is_idle

   !> Whether a block gives an option the value that it has without being given: effective decks of earlier versions give all.
   pure logical function is_default(option, spec)
      type(option_type), intent(in) :: option
      !> Row of the option
      type(option_spec_type), intent(in) :: spec
      integer, parameter :: whole(*) = [kind_count, kind_counting], numbers(*) = [kind_real, kind_positive, kind_nonnegative, whole]
      real(wp) :: value
      integer :: status
      is_default = .false.
      if (spec%default == '' .or. spec%default == needed) return
      is_default = option%text == trim(spec%default)
      if (is_default .or. all(spec%kind /= numbers)) return
      read (spec%default, *, iostat=status) value
      if (status /= 0) return
      is_default = abs(option%value - value) <= 0.0_wp
      if (any(spec%kind == whole)) is_default = option%whole == nint(value)
   end function is_default

   !> Whether a block gives an option the value that it has without being given. NO of an option without a default is that, too.
   pure logical function gives_default(block, name)
      type(block_type), intent(in) :: block
      !> Of the option, in upper case
      character(*), intent(in) :: name
      type(option_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_options(block%keyword))
      gives_default = .false.
      do i = 1, size(specs)
         if (specs(i)%name /= name) cycle
         gives_default = is_default(block%options(i), specs(i))
         if (specs(i)%kind == kind_yes .and. specs(i)%default == '') gives_default = block%options(i)%text == 'NO'
      end do
   end function gives_default

   !> Reports the first given option of a block that has no effect: the others may have none for the same reason. One that gives its
   !> default is no mistake.
   subroutine check_idle(block, specs, diagnostics)
      type(block_type), intent(in) :: block
      !> Rows of its options
      type(option_spec_type), intent(in) :: specs(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(specs)
         if (.not. block%options(i)%given) cycle
         if (.not. is_idle(block, specs(i)) .or. is_default(block%options(i), specs(i))) cycle
         call complain(block, specs(i), block%options(i)%origin, diagnostics)
         return
      end do
   end subroutine check_idle

   !> Reports an option without effect, and where it has one.
   subroutine complain(block, spec, origin, diagnostics)
      type(block_type), intent(in) :: block
      type(option_spec_type), intent(in) :: spec
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: name, other
      integer :: equals
      name = trim(spec%name)
      equals = index(spec%only, '=')
      if (spec%only(1:1) == '-') then
         other = trim(spec%only(2:))
         call diagnostics%add(origin, name//' means nothing beside '//other, 'leave one of the two out')
      else if (equals == 0) then
         other = trim(spec%only)
         call diagnostics%add(origin, name//' means nothing without '//other, 'leave it out, or add '//other//'=')
      else
         other = spec%only(:equals - 1)
         call diagnostics%add(origin, name//' means nothing with '//other//'='//block%word(other), 'leave it out; it is for '// &
            & other//'='//alternatives(trim(spec%only(equals + 1:)), ''))
      end if
   end subroutine complain

end module limber_deck_idle_options
