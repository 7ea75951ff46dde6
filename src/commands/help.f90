!> limber help and limber --version. Floor: commands.
module limber_commands_help
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: newline, uppercase, nearest_name
   use limber_base_version, only: version, commit, compiler, compiler_options
   use limber_deck_keyword_help, only: help_text, manual_text, asks_for_group
   use limber_deck_keywords, only: keyword_table, option_table, find_keyword, load_language
   use limber_model_quantities, only: quantity_help, quantity_manual
   implicit none
   private
   public :: help_on, version_text

contains

   !> Help on one keyword, a list of all, or the whole reference chapter of the manual.
   subroutine help_on(words, manual, report, error)
      !> Words of a keyword: 'rigid', 'body'
      character(*), intent(in) :: words(:)
      !> True for the chapter in Markdown
      logical, intent(in) :: manual
      character(:), allocatable, intent(out) :: report
      !> No such keyword
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: keyword
      integer :: i, near
      call load_language()
      if (manual) then
         report = manual_text()//newline//'## Quantities'//newline//newline//quantity_manual()
         return
      end if
      keyword = ''
      do i = 1, size(words)
         keyword = trim(keyword//' '//trim(words(i)))
      end do
      keyword = uppercase(trim(adjustl(keyword)))
      if (len(keyword) > 0) then
         if (keyword(1:1) == '*') keyword = keyword(2:)
         if (find_keyword(keyword) == 0 .and. any(option_table%name == keyword)) then
            report = owners(keyword)
            return
         end if
         if (find_keyword(keyword) == 0 .and. .not. asks_for_group(keyword)) then
            near = nearest_name(keyword, keyword_table%name)
            if (near > 0) then
               call raise(error, 'there is no keyword *'//keyword//'; did you mean *'//trim(keyword_table(near)%name)//'?', &
                  & status_deck)
            else
               call raise(error, 'there is no keyword *'//keyword//newline//help_text(''), status_deck)
            end if
            report = ''
            return
         end if
      end if
      report = help_text(keyword)
      if (keyword == 'OUTPUT') report = report//newline//quantity_help()
   end subroutine help_on

   !> The keywords that have an option.
   pure function owners(option) result(text)
      character(*), intent(in) :: option
      character(:), allocatable :: text
      integer :: i
      text = option//' is an option; see'
      do i = 1, size(option_table)
         if (option_table(i)%name == option) text = text//newline//'   limber help '//trim(option_table(i)%keyword)// &
            & '   '//trim(option_table(i)%meaning)
      end do
   end function owners

   !> Version, commit, compiler and its options.
   pure function version_text() result(text)
      character(:), allocatable :: text
      text = 'limber '//version//' ('//commit//')'//newline//compiler//newline//compiler_options
   end function version_text

end module limber_commands_help
