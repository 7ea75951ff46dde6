!> Form of a row of the keyword table. The rows themselves are in `limber_deck_keywords`. Floor: deck.
module limber_deck_schema
   implicit none
   private
   public :: keyword_type, option_spec_type, field_spec_type, list_spec_type, word_spec_type, keyword_rows_type, many, needed
   public :: kind_name, kind_reference, kind_real, kind_positive, kind_nonnegative, kind_count, kind_counting, &
      & kind_word, kind_text, kind_path, kind_point, kind_yes, kind_time_expression, kind_law, kind_spring_law, kind_shape, &
      & kind_curve, kind_label, kind_range
   public :: form_none, form_text, form_fields, form_assignments, form_channels, form_lists
   public :: is_number_kind, is_integer_kind, is_expression_kind

   !> Name of an object that the block defines; `values`: the name space, whose names differ from each other
   integer, parameter :: kind_name = 1
   !> Name of an object; `values`: the keywords that may define it, separated by |
   integer, parameter :: kind_reference = 2
   !> Any real number; one above zero; one that is not negative
   integer, parameter :: kind_real = 3, kind_positive = 4, kind_nonnegative = 5
   !> A whole number from 0; from 1
   integer, parameter :: kind_count = 6, kind_counting = 7
   !> One of the `values`, separated by |
   integer, parameter :: kind_word = 8
   !> Free text; the path of a file
   integer, parameter :: kind_text = 9, kind_path = 10
   !> `object` or `object.point`; YES or NO; an expression of the time t
   integer, parameter :: kind_point = 11, kind_yes = 12, kind_time_expression = 13
   !> An expression of t and of quantities of the motion; the same, of x and v too; an expression of s alone
   integer, parameter :: kind_law = 14, kind_spring_law = 15, kind_shape = 16
   !> An expression of x alone
   integer, parameter :: kind_curve = 17
   !> A name or a constant number
   integer, parameter :: kind_label = 18
   !> A constant number; or first:last, or first:last:count
   integer, parameter :: kind_range = 19

   !> Forms of data lines: none, free text, one row of fields in each line, name = expression,
   !> channels of the output, named lists of values
   integer, parameter :: form_none = 0, form_text = 1, form_fields = 2, form_assignments = 3, form_channels = 4, &
      & form_lists = 5

   !> Any number of blocks or lines
   integer, parameter :: many = huge(1)
   !> In the column of defaults: the option must be given
   character(*), parameter :: needed = '!'

   !> A keyword
   type :: keyword_type
      !> In upper case, without the asterisk
      character(16) :: name
      !> Most blocks of a deck
      integer :: most
      !> Form, least and greatest number of its data lines
      integer :: form, least_lines, most_lines
      !> One line
      character(110) :: meaning
   end type keyword_type

   !> An option of a keyword
   type :: option_spec_type
      !> Keyword that it belongs to, and its own name, in upper case
      character(16) :: keyword
      character(20) :: name
      integer :: kind
      !> Depends on the kind
      character(120) :: values
      !> Unit of a number in SI
      character(12) :: unit
      !> As it would be written; empty: none; `needed`: must be given
      character(16) :: default
      !> One line
      character(110) :: meaning
      !> Of a whole number: the greatest
      integer :: most = many
      !> Models of a body for which it means something; empty: all. EXACT: exact beams; MODES: beams and frames with modes; LARGE:
      !> frames
      !> of exact beams
      character(5) :: models = ''
      !> When it has an effect; empty: always. 'TYPE=ROD|BELT': if that option has one of these words; 'ROTATION': if that option is
      !> given; '-FIXED STEP': if that one is not
      character(88) :: only = ''
   end type option_spec_type

   !> A field of the data lines of a keyword
   type :: field_spec_type
      character(16) :: keyword
      !> What the field is called in messages
      character(20) :: name
      integer :: kind
      character(8) :: unit
      character(90) :: meaning
      !> Whether a line may end before it; whether any number of fields of its kind may follow, if it is the last
      logical :: optional = .false., repeated = .false.
   end type field_spec_type

   !> A list that a data line of the form `form_lists` gives: its name, then values of an option of the table
   type :: list_spec_type
      character(16) :: keyword
      !> In lower case
      character(20) :: name
      !> Keyword and option that the values are for; without them the values are names
      character(16) :: of
      character(20) :: option
      character(90) :: meaning
   end type list_spec_type

   !> Meaning of a word of an option
   type :: word_spec_type
      character(16) :: keyword
      character(20) :: word
      !> One or two lines
      character(230) :: meaning
   end type word_spec_type

   !> All rows of one keyword
   type :: keyword_rows_type
      type(keyword_type) :: keyword
      type(option_spec_type), allocatable :: options(:)
      type(field_spec_type), allocatable :: fields(:)
      !> Meaning of words of its options
      type(word_spec_type), allocatable :: words(:)
      !> Lines of its example
      character(110), allocatable :: example(:)
   end type keyword_rows_type

contains

   !> Whether values of a kind are constant numbers.
   elemental logical function is_number_kind(kind)
      integer, intent(in) :: kind
      is_number_kind = kind >= kind_real .and. kind <= kind_counting
   end function is_number_kind

   !> Whether they are whole numbers.
   elemental logical function is_integer_kind(kind)
      integer, intent(in) :: kind
      is_integer_kind = kind == kind_count .or. kind == kind_counting
   end function is_integer_kind

   !> Whether they are expressions of more than constants.
   elemental logical function is_expression_kind(kind)
      integer, intent(in) :: kind
      is_expression_kind = kind == kind_time_expression .or. kind == kind_law .or. kind == kind_spring_law .or. kind == kind_shape &
         & .or. kind == kind_curve
   end function is_expression_kind

end module limber_deck_schema
