!> Gears: TYPE=GEAR. Floor: elements. Source: doc/theory, eq. (3.15).
module limber_elements_gear
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type, kind_positive, kind_yes
   use limber_model_joint_kind, only: joint_kind_type, rolling_wheels
   use limber_model_model, only: joint_type, place_rolling
   implicit none
   private
   public :: gear_kind_type, gear_kind

   type, extends(joint_kind_type) :: gear_kind_type
   contains
      procedure :: read
      procedure :: describe
   end type gear_kind_type

contains

   pure type(gear_kind_type) function gear_kind() result(kind)
      kind%word = 'GEAR'
      kind%meaning = 'gears about the two points, whoever carries these: they roll off each other where the line of ' &
         & //'centres meets them, and push across it; teeth mesh as in the first guess'
      kind%place = place_rolling
      kind%apart = .true.
      kind%clamps = .true.
      kind%needs = 'FIRST RADIUS|SECOND RADIUS'
      allocate (kind%options, source=[ &
         & option_spec_type('JOINT', 'FIRST RADIUS', kind_positive, '', 'm', '', 'GEAR, BELT: radius on the first body', &
         &    only='TYPE=GEAR|BELT'), &
         & option_spec_type('JOINT', 'SECOND RADIUS', kind_positive, '', 'm', '', 'GEAR, BELT: radius on the second body', &
         &    only='TYPE=GEAR|BELT'), &
         & option_spec_type('JOINT', 'INTERNAL', kind_yes, '', '', '', 'GEAR: one gear runs inside the other', &
         &    only='TYPE=GEAR')])
   end function gear_kind

   subroutine read(self, block, joint, diagnostics)
      class(gear_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      joint%radius = [block%real('FIRST RADIUS'), block%real('SECOND RADIUS')]
      joint%same_direction = block%yes('INTERNAL')
   end subroutine read

   !> Angles of both sections less the direction of the line of centres, each times its radius.
   pure subroutine describe(self, joint)
      class(gear_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=rolling_wheels(joint))
      joint%zero = .false.
   end subroutine describe

end module limber_elements_gear
