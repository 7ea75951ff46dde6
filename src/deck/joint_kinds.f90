!> Kinds of joints. A row for each says what it is called and means, and what it holds; its equations are in
!> `limber_multibody_constraint_list`. Floor: deck.
module limber_deck_joint_kinds
   implicit none
   private
   public :: joint_kind_type, joint_kind

   !> What a joint demands of the place of its first point: nothing; the place of the second; a line through that, at ANGLE; a curve
   !> around it; the line of a beam; a distance from it. Or wheels roll on each other, whose centres others hold
   integer, parameter, public :: place_free = 0, place_at_point = 1, place_on_line = 2, place_on_curve = 3, place_on_beam = 4, &
      & place_at_distance = 5, place_rolling = 6

   !> A kind of joints
   type :: joint_kind_type
      !> TYPE in the deck
      character(14) :: word
      !> One of the above
      integer :: place
      !> Whether it keeps the angle of the first section from the second
      logical :: keeps_angle
      !> Whether its equations need two points that are apart in the first guess
      logical :: apart
      !> Options that it needs, separated by |
      character(28) :: needs
      !> One or two lines
      character(230) :: meaning
   end type joint_kind_type

   !> Kinds of joints: rows of the table
   integer, parameter, public :: joint_revolute = 1, joint_point_on_line = 2, joint_translational = 3, joint_weld = 4, &
      & joint_rod = 5, joint_curve = 6, joint_sliding = 7, joint_gear = 8, joint_rack = 9, joint_belt = 10, joint_coupler = 11

   !> The table; the last row is no TYPE, a coupler counts as a joint
   type(joint_kind_type), parameter, public :: joint_kinds(*) = [ &
      & joint_kind_type('REVOLUTE', place_at_point, .false., .false., '', &
      &    'the two points coincide'), &
      & joint_kind_type('POINT ON LINE', place_on_line, .false., .false., '', &
      &    'the first point stays on the line through the second one, at ANGLE in the section there: a pin in a slot'), &
      & joint_kind_type('TRANSLATIONAL', place_on_line, .true., .false., '', &
      &    'the same, and the first section keeps its angle from the second'), &
      & joint_kind_type('WELD', place_at_point, .true., .false., '', &
      &    'the points coincide, and the first section keeps its angle from the second'), &
      & joint_kind_type('ROD', place_at_distance, .false., .true., '', &
      &    'the distance of the points stays LENGTH'), &
      & joint_kind_type('POINT ON CURVE', place_on_curve, .false., .false., 'CURVE', &
      &    'the first point stays on CURVE, whose origin is the second point, its x axis at ANGLE in the section there; ' &
      &    //'a cam. A kink is an impact, a jump is refused; behind its ends an open curve is straight'), &
      & joint_kind_type('SLIDING', place_on_beam, .false., .false., '', &
      &    'the first point slides along the line of the *BEAM that the second point names, as that bends; the beam has ' &
      &    //'at most 24 coordinates: functions of the angle, the strain, one for each place where something acts along it'), &
      & joint_kind_type('GEAR', place_rolling, .false., .true., 'FIRST RADIUS|SECOND RADIUS', &
      &    'gears about the two points, whoever carries these: they roll off each other where the line of ' &
      &    //'centres meets them, and push across it; teeth mesh as in the first guess'), &
      & joint_kind_type('RACK', place_rolling, .false., .false., 'RADIUS', &
      &    'a pinion about the first point rolls along the line through the second one, at ANGLE in the section ' &
      &    //'there, on the side where it is in the first guess'), &
      & joint_kind_type('BELT', place_rolling, .false., .true., 'FIRST RADIUS|SECOND RADIUS', &
      &    'a belt or chain over wheels about the two points, which neither slips nor stretches; their distance ' &
      &    //'is to be kept by other joints'), &
      & joint_kind_type('', place_free, .false., .false., '', '')]

   !> The words of TYPE, separated by |
   character(*), parameter, public :: joint_words = trim(joint_kinds(1)%word)//'|'//trim(joint_kinds(2)%word)//'|' &
      & //trim(joint_kinds(3)%word)//'|'//trim(joint_kinds(4)%word)//'|'//trim(joint_kinds(5)%word)//'|' &
      & //trim(joint_kinds(6)%word)//'|'//trim(joint_kinds(7)%word)//'|'//trim(joint_kinds(8)%word)//'|' &
      & //trim(joint_kinds(9)%word)//'|'//trim(joint_kinds(10)%word)

contains

   !> Row of a kind by its word in the deck; the first if there is none.
   pure integer function joint_kind(word) result(row)
      character(*), intent(in) :: word
      do row = 1, size(joint_kinds) - 1
         if (joint_kinds(row)%word == word) return
      end do
      row = 1
   end function joint_kind

end module limber_deck_joint_kinds
