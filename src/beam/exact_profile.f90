!> Sections of an exact beam along its axis. Stretches, in each of which rigidities and masses are polynomials of fourth degree, so
!> that linear tapers of height, width and diameter are exact. Floor: beam. Source: doc/theory, part 2, eq. (2.50).
module limber_beam_exact_profile
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: profile_type, uniform_profile, profile_at, profile_mean
   public :: of_ea, of_ei, of_ga, of_mass, of_rotary, profile_values, profile_places

   !> What a profile gives: axial rigidity E A [force], bending rigidity E I [force length^2], shear rigidity kappa G A [force],
   !> mass per length, rotary inertia per length rho I [mass length]
   integer, parameter :: of_ea = 1, of_ei = 2, of_ga = 3, of_mass = 4, of_rotary = 5, profile_values = 5
   !> Places in a stretch where they are given, at equal distances from its start to its end
   integer, parameter :: profile_places = 5

   !> Sections of a beam
   type :: profile_type
      !> Starts of the stretches, and the end of the last (0:stretches) [length]
      real(wp), allocatable :: at(:)
      !> Values (profile_values, profile_places, stretches)
      real(wp), allocatable :: value(:, :, :)
   end type profile_type

contains

   !> The profile of a uniform beam without shear and rotary inertia.
   pure function uniform_profile(ea, ei, mass, length) result(profile)
      !> [force], [force length^2], [mass/length], [length]
      real(wp), intent(in) :: ea, ei, mass, length
      type(profile_type) :: profile
      allocate (profile%at(0:1), profile%value(profile_values, profile_places, 1))
      profile%at = [0.0_wp, length]
      profile%value = 0.0_wp
      profile%value(of_ea, :, 1) = ea
      profile%value(of_ei, :, 1) = ei
      profile%value(of_mass, :, 1) = mass
   end function uniform_profile

   !> Values at a place (profile_values); where two stretches meet, of the second.
   pure function profile_at(profile, s) result(value)
      type(profile_type), intent(in) :: profile
      real(wp), intent(in) :: s
      real(wp) :: value(profile_values), x, part
      integer :: stretch, i, j
      stretch = min(max(1, count(profile%at(:size(profile%at) - 2) <= s)), size(profile%value, 3))
      x = (profile_places - 1)*(s - profile%at(stretch - 1))/(profile%at(stretch) - profile%at(stretch - 1))
      value = 0.0_wp
      do i = 1, profile_places
         part = 1.0_wp
         do j = 1, profile_places
            if (j /= i) part = part*(x - (j - 1))/(i - j)
         end do
         value = value + part*profile%value(:, i, stretch)
      end do
   end function profile_at

   !> Mean values along the beam (profile_values), by Boole's rule.
   pure function profile_mean(profile) result(mean)
      type(profile_type), intent(in) :: profile
      real(wp) :: mean(profile_values)
      real(wp), parameter :: weight(profile_places) = [7, 32, 12, 32, 7]/90.0_wp
      integer :: i
      mean = 0.0_wp
      do i = 1, size(profile%value, 3)
         mean = mean + matmul(profile%value(:, :, i), weight)*(profile%at(i) - profile%at(i - 1))
      end do
      mean = mean/profile%at(size(profile%at) - 1)
   end function profile_mean

end module limber_beam_exact_profile
