!> Belt or chain over wheels: TYPE=BELT. Floor: elements. Source: doc/theory, eq. (3.15).
module limber_elements_belt
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type, kind_yes
   use limber_model_joint_kind, only: joint_kind_type, rolling_wheels
   use limber_model_model, only: joint_type, place_rolling
   implicit none
   private
   public :: belt_kind_type, belt_kind

   type, extends(joint_kind_type) :: belt_kind_type
   contains
      procedure :: read
      procedure :: describe
   end type belt_kind_type

contains

   !> Its radii are options of GEAR too.
   pure type(belt_kind_type) function belt_kind() result(kind)
      kind%word = 'BELT'
      kind%meaning = 'a belt or chain over wheels about the two points, which neither slips nor stretches; other joints ' &
         & //'keep their distance. Without pretension: bearings get the difference of its strands alone'
      kind%place = place_rolling
      kind%apart = .true.
      kind%clamps = .true.
      kind%needs = 'FIRST RADIUS|SECOND RADIUS'
      allocate (kind%options, source=[option_spec_type('JOINT', 'CROSSED', kind_yes, '', '', '', &
         & 'BELT: crossed, so that the wheels turn against each other', only='TYPE=BELT')])
   end function belt_kind

   subroutine read(self, block, joint, diagnostics)
      class(belt_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      joint%radius = [block%real('FIRST RADIUS'), block%real('SECOND RADIUS')]
      joint%same_direction = .not. block%yes('CROSSED')
   end subroutine read

   !> Angles of both sections less the direction of the line of centres, each times its radius.
   pure subroutine describe(self, joint)
      class(belt_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=rolling_wheels(joint))
      joint%zero = .false.
      if (.not. joint%same_direction) joint%symbol = 'CROSSED BELT'
   end subroutine describe

end module limber_elements_belt
