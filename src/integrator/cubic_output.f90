!> Dense output of order 3. The cubic through coordinates and rates at both ends of a step, its derivative for the rates. Floor:
!> integrator. Source: Hermite interpolation; rotations by `advance`.
module limber_integrator_cubic_output
   use limber_base_kinds, only: wp
   use limber_multibody_layout, only: layout_type, velocities_of, advance
   implicit none
   private
   public :: cubic_state

contains

   !> Coordinates and velocities at a part of a step.
   pure subroutine cubic_state(layout, part, h, q_before, increment, w_before, w, rates, q, v)
      type(layout_type), intent(in) :: layout
      !> Part of the step that has gone, 0 to 1, and its length
      real(wp), intent(in) :: part, h
      !> Coordinates at its beginning (nq), its increment (nw), rates at its beginning and its end (nw)
      real(wp), intent(in) :: q_before(:), increment(:), w_before(:), w(:)
      !> Scratch (nw)
      real(wp), intent(inout) :: rates(:)
      !> Coordinates and velocities (nq)
      real(wp), intent(inout) :: q(:), v(:)
      associate (s => part)
         rates = s**2*(3 - 2*s)*increment + h*(s*(1 - s)**2*w_before - s**2*(1 - s)*w)
         call advance(layout, q_before, rates, q)
         rates = 6*s*(1 - s)/h*increment + (1 - s)*(1 - 3*s)*w_before - s*(2 - 3*s)*w
         call velocities_of(layout, q, rates, v)
      end associate
   end subroutine cubic_state

end module limber_integrator_cubic_output
