!> Meaning of single words of the keyword table, for help. `limber help` and the manual show them behind the data lines. Floor:
!> deck.
module limber_deck_words
   use limber_deck_joint_kinds, only: joint_kinds
   implicit none
   private
   public :: word_spec_type, keyword_words

   !> Meaning of a word of an option
   type :: word_spec_type
      character(16) :: keyword
      character(20) :: word
      !> One or two lines
      character(230) :: meaning
   end type word_spec_type

   !> All words but those of joints, in the order of their option
   type(word_spec_type), parameter :: word_table(*) = [ &
      & word_spec_type('DRIVER', 'ANGLE', &
      &    'angle of the frame of BODY, or joint_angle(JOINT)'), &
      & word_spec_type('DRIVER', 'DISTANCE', &
      &    'distance of POINT and TO, above 0'), &
      & word_spec_type('DRIVER', 'DISPLACEMENT', &
      &    'displacement(JOINT); of SLIDING the coordinate along the undeformed axis from the second point, so that the ' &
      &    //'force acts where the first point is, along the tangent there; laws of loads cannot use it'), &
      & word_spec_type('DRIVER', 'X', &
      &    'coordinate of POINT along the fixed x axis; Y: along the y axis')]

contains

   !> The words of a keyword.
   pure function keyword_words(keyword) result(words)
      !> In upper case
      character(*), intent(in) :: keyword
      type(word_spec_type), allocatable :: words(:)
      integer :: i
      if (keyword == 'JOINT') then
         allocate (words(size(joint_kinds) - 1))
         do i = 1, size(words)
            words(i) = word_spec_type(keyword, joint_kinds(i)%word, joint_kinds(i)%meaning)
         end do
         return
      end if
      allocate (words(count(word_table%keyword == keyword)))
      words(:) = word_table(pack([(i, i=1, size(word_table))], word_table%keyword == keyword))
   end function keyword_words

end module limber_deck_words
