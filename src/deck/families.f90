!> Options of a beam that mean something for some of its models only. Floor: deck.
module limber_deck_families
   implicit none
   private
   public :: is_void

   !> Of the models with modes, and of exact beams
   character(*), parameter, public :: options_of_modes(14) = [character(18) :: 'MODES', 'BENDING MODES', 'AXIAL MODES', &
      & 'FREQUENCY LIMIT', 'BASIS', 'CORRECTIONS', 'END SHAPES', 'GEOMETRIC ELEMENTS', 'GEOMETRIC INTEGRAL', 'AXIAL BASIS', &
      & 'END FORCE', 'CENTRIFUGAL', 'MODAL DERIVATIVES', 'AXIAL DYNAMICS']
   character(*), parameter, public :: options_of_exact(8) = [character(18) :: 'FUNCTIONS', 'STRAIN FUNCTIONS', 'SHEAR', &
      & 'END SECTION', 'CURVATURE', 'THERMAL STRAIN', 'THERMAL CURVATURE', 'PRETENSION']

contains

   !> Whether an option means nothing of a beam.
   pure logical function is_void(keyword, model, option)
      !> Of the block; its GEOMETRIC; the option's name
      character(*), intent(in) :: keyword, model, option
      is_void = .false.
      if (keyword /= 'BEAM') return
      if (model == 'EXACT') then
         is_void = any(options_of_modes == option)
      else
         is_void = any(options_of_exact == option)
      end if
   end function is_void

end module limber_deck_families
