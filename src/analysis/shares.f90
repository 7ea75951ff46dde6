!> What parts of a target count, in the choice of a setting, in its verification and in the climb alike. Floor: analysis.
!> Source: doc/theory, eqs. (177) to (185).
module limber_analysis_shares
   use limber_base_kinds, only: wp
   implicit none
   private

   !> Parts of the target that the models and the integration may have; the rest is for the doubt about the verification
   real(wp), parameter, public :: part_model = 0.65_wp, part_time = 0.3_wp
   !> Part of the target below which the expected or measured error of a beam does not matter, and part below which all that its
   !> deflection does to the channels does not
   real(wp), parameter, public :: no_matter = 0.02_wp, no_effect = 0.2_wp

end module limber_analysis_shares
