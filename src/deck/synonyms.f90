!> Words of other programs and the deck's words for them, for messages. Floor: deck.
module limber_deck_synonyms
   implicit none
   private
   public :: word_in_deck, advice_for, successor_of

   !> A word that is often written, and that of the deck language
   type :: synonym_type
      !> In upper case
      character(16) :: written
      character(20) :: meant
   end type synonym_type

   !> A keyword of other programs, and how its purpose is reached here
   type :: remark_type
      !> In upper case
      character(20) :: written
      character(130) :: advice
   end type remark_type

   !> Words of options and their values
   type(synonym_type), parameter :: synonyms(*) = [ &
      & synonym_type('CENTER X', 'CENTRE X'), &
      & synonym_type('CENTER Y', 'CENTRE Y'), &
      & synonym_type('PRISMATIC', 'TRANSLATIONAL'), &
      & synonym_type('SLIDER', 'TRANSLATIONAL'), &
      & synonym_type('INLINE', 'POINT ON LINE'), &
      & synonym_type('SLOT', 'POINT ON LINE'), &
      & synonym_type('PIN IN SLOT', 'POINT ON LINE'), &
      & synonym_type('PIN', 'REVOLUTE'), &
      & synonym_type('HINGE', 'REVOLUTE'), &
      & synonym_type('SPHERICAL', 'REVOLUTE'), &
      & synonym_type('FIXED', 'WELD'), &
      & synonym_type('RIGID', 'WELD'), &
      & synonym_type('CLAMPED', 'WELD'), &
      & synonym_type('CAM', 'POINT ON CURVE'), &
      & synonym_type('LINK', 'ROD'), &
      & synonym_type('DISTANCE', 'ROD'), &
      & synonym_type('CHAIN', 'BELT'), &
      & synonym_type('PINION', 'RACK'), &
      & synonym_type('ROTATION', 'ANGLE'), &
      & synonym_type('TRANSLATION', 'DISPLACEMENT'), &
      & synonym_type('CIRC', 'CIRCLE'), &
      & synonym_type('ROUND', 'CIRCLE'), &
      & synonym_type('RECT', 'RECTANGLE'), &
      & synonym_type('BOX', 'RECTANGLE'), &
      & synonym_type('PIPE', 'TUBE'), &
      & synonym_type('ELASTIC MODULUS', 'YOUNG'), &
      & synonym_type('E', 'YOUNG'), &
      & synonym_type('RHO', 'DENSITY'), &
      & synonym_type('RADIUS', 'DIAMETER'), &
      & synonym_type('J', 'INERTIA'), &
      & synonym_type('I', 'INERTIA'), &
      & synonym_type('M', 'MASS'), &
      & synonym_type('OMEGA', 'SPIN'), &
      & synonym_type('K', 'STIFFNESS'), &
      & synonym_type('C', 'DAMPING'), &
      & synonym_type('FREE LENGTH', 'LENGTH'), &
      & synonym_type('END TIME', 'END'), &
      & synonym_type('DURATION', 'END'), &
      & synonym_type('STOP', 'END'), &
      & synonym_type('TIME', 'END'), &
      & synonym_type('STEPS', 'OUTPUTS'), &
      & synonym_type('RTOL', 'TOLERANCE'), &
      & synonym_type('STEP', 'FIXED STEP')]

   !> Keywords
   type(remark_type), parameter :: advices(*) = [ &
      & remark_type('CONTACT', 'write *STOP for a limit of a distance or joint, else *FORCE with max(0, stiffness*depth)'), &
      & remark_type('IMPACT', 'write *STOP for a limit of a distance or joint, else *FORCE with max(0, stiffness*depth)'), &
      & remark_type('BODY', 'a body is a *RIGID BODY, *POINT MASS, *BEAM or *FRAME'), &
      & remark_type('HINGE', 'write *JOINT, TYPE=REVOLUTE'), &
      & remark_type('REVOLUTE', 'write *JOINT, TYPE=REVOLUTE'), &
      & remark_type('PRISMATIC', 'write *JOINT, TYPE=TRANSLATIONAL'), &
      & remark_type('TRANSLATIONAL', 'write *JOINT, TYPE=TRANSLATIONAL'), &
      & remark_type('WELD', 'write *JOINT, TYPE=WELD'), &
      & remark_type('GEAR', 'write *JOINT, TYPE=GEAR'), &
      & remark_type('RACK', 'write *JOINT, TYPE=RACK'), &
      & remark_type('BELT', 'write *JOINT, TYPE=BELT'), &
      & remark_type('CAM', 'write *JOINT, TYPE=POINT ON CURVE, and *CURVE'), &
      & remark_type('ROD', 'write *JOINT, TYPE=ROD'), &
      & remark_type('CONSTRAINT', 'joints are *JOINT and *COUPLER, given motions *DRIVER and *MOTION'), &
      & remark_type('MOTOR', 'a given motion is a *DRIVER, a given torque a *TORQUE'), &
      & remark_type('ACTUATOR', 'a given motion is a *DRIVER, a force between points a *SPRING with a law'), &
      & remark_type('DAMPER', 'write *SPRING, DAMPING=...'), &
      & remark_type('LIMIT', 'write *STOP'), &
      & remark_type('ROPE', 'write *STOP, MOST=length: a rope that goes slack; or a *SPRING, which pushes too'), &
      & remark_type('LOAD', 'loads are *FORCE, *TORQUE, *SPRING and *DISTRIBUTED LOAD'), &
      & remark_type('CLOAD', 'write *FORCE'), &
      & remark_type('DLOAD', 'write *DISTRIBUTED LOAD'), &
      & remark_type('STEP', 'analyses are *STATICS, *KINEMATICS, *INVERSE DYNAMICS, *MODES and *DYNAMICS'), &
      & remark_type('END STEP', 'leave it out: an analysis ends where the next one begins'), &
      & remark_type('BEAM GENERAL SECTION', 'write *SECTION, and *BEAM SECTION for a set of members'), &
      & remark_type('FRAME SECTION', 'write *SECTION, and *BEAM SECTION for a set of members'), &
      & remark_type('STATIC', 'write *STATICS'), &
      & remark_type('DYNAMIC', 'write *DYNAMICS'), &
      & remark_type('FREQUENCY', 'write *MODES'), &
      & remark_type('BUCKLE', 'write *STATICS: it finds critical loads'), &
      & remark_type('ELASTIC', 'write *MATERIAL, NAME=..., YOUNG=..., DENSITY=...'), &
      & remark_type('INITIAL CONDITIONS', 'write X, Y, ANGLE, VX, VY and SPIN of the bodies'), &
      & remark_type('AMPLITUDE', 'write *TABLE, and its name as a function of t'), &
      & remark_type('MARKER', 'named points are data lines of their body'), &
      & remark_type('END', 'a deck ends with its last line')]

   character(*), parameter :: gone_with_full = 'leave it out: it went with FULL, whose successor is GEOMETRIC=EXACT'
   !> Options and words of earlier versions
   type(remark_type), parameter :: removals(*) = [ &
      & remark_type('FULL', 'its successor is EXACT, the default of *BEAM; a *FRAME has K_G'), &
      & remark_type('END FORCE', gone_with_full), &
      & remark_type('CENTRIFUGAL', gone_with_full), &
      & remark_type('MODAL DERIVATIVES', gone_with_full), &
      & remark_type('END SHAPES', 'write CORRECTIONS=YES, or leave it out with GEOMETRIC=EXACT'), &
      & remark_type('BASIS', 'a *BEAM has CORRECTIONS=YES, a *FRAME has BASIS'), &
      & remark_type('FREQUENCY LIMIT', 'a *BEAM has BENDING MODES and AXIAL MODES, a *FRAME has FREQUENCY LIMIT'), &
      & remark_type('AXIAL DYNAMICS', 'an EXACT beam with STRAIN FUNCTIONS=0 has no axial vibrations')]

contains

   !> The word of the deck language that a common word stands for, if it is among those that are possible; else empty.
   pure function word_in_deck(written, possible) result(word)
      !> In upper case
      character(*), intent(in) :: written
      !> In upper case
      character(*), intent(in) :: possible(:)
      character(:), allocatable :: word
      integer :: i
      word = ''
      do i = 1, size(synonyms)
         if (synonyms(i)%written /= written) cycle
         if (.not. any(possible == synonyms(i)%meant)) cycle
         word = trim(synonyms(i)%meant)
         return
      end do
   end function word_in_deck

   !> How the purpose of a keyword of other programs is reached; empty if that is not known.
   pure function advice_for(keyword) result(advice)
      !> In upper case
      character(*), intent(in) :: keyword
      character(:), allocatable :: advice
      integer :: i
      advice = ''
      do i = 1, size(advices)
         if (advices(i)%written == keyword) advice = trim(advices(i)%advice)
      end do
   end function advice_for

   !> What took the place of an option or word of earlier versions; empty if there was none of that name.
   pure function successor_of(word) result(advice)
      !> In upper case
      character(*), intent(in) :: word
      character(:), allocatable :: advice
      integer :: i
      advice = ''
      do i = 1, size(removals)
         if (removals(i)%written == word) advice = trim(removals(i)%advice)
      end do
   end function successor_of

end module limber_deck_synonyms
