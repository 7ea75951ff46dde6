!> Meaning of single words of the keyword table, for help. `limber help` and the manual show them behind the data lines. Floor:
!> deck.
module limber_deck_words
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

   !> All words, in the order of their option
   type(word_spec_type), parameter :: word_table(*) = [ &
      & word_spec_type('JOINT', 'REVOLUTE', &
      &    'the two points coincide'), &
      & word_spec_type('JOINT', 'POINT ON LINE', &
      &    'the first point stays on the line through the second one, at ANGLE in the section there: a pin in a ' &
      &    //'slot'), &
      & word_spec_type('JOINT', 'TRANSLATIONAL', &
      &    'the same, and the first section keeps its angle from the second'), &
      & word_spec_type('JOINT', 'WELD', &
      &    'the points coincide, and the first section keeps its angle from the second'), &
      & word_spec_type('JOINT', 'ROD', &
      &    'the distance of the points stays LENGTH'), &
      & word_spec_type('JOINT', 'POINT ON CURVE', &
      &    'the first point stays on CURVE, whose origin is the second point, its x axis at ANGLE in the ' &
      &    //'section there; a cam. A kink is an impact, a jump is refused; behind its ends an open curve is straight'), &
      & word_spec_type('JOINT', 'SLIDING', &
      &    'the first point slides along the line of the *BEAM that the second point names, as that bends; the beam has ' &
      &    //'at most 24 coordinates: functions of the angle, the strain, one for each place where something acts along it'), &
      & word_spec_type('JOINT', 'GEAR', &
      &    'gears about the two points, whoever carries these: they roll off each other where the line of ' &
      &    //'centres meets them, and push across it; teeth mesh as in the first guess'), &
      & word_spec_type('JOINT', 'RACK', &
      &    'a pinion about the first point rolls along the line through the second one, at ANGLE in the section ' &
      &    //'there, on the side where it is in the first guess'), &
      & word_spec_type('JOINT', 'BELT', &
      &    'a belt or chain over wheels about the two points, which neither slips nor stretches; their distance ' &
      &    //'is to be kept by other joints'), &
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
      allocate (words(count(word_table%keyword == keyword)))
      words(:) = word_table(pack([(i, i=1, size(word_table))], word_table%keyword == keyword))
   end function keyword_words

end module limber_deck_words
