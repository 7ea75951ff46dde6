!> Base of joints of a point that slides along a beam, whatever the model of the beam. Floor: multibody. Source: doc/theory,
!> eqs. (3.22)-(3.27).
module limber_multibody_beam_path
   use limber_base_kinds, only: wp
   use limber_multibody_function_constraints, only: function_constraint_type
   implicit none
   private
   public :: beam_path_type

   !> A point on the line of a beam; the first two variables are its place in the frame of the beam, the others the coordinates of
   !> the beam
   type, abstract, extends(function_constraint_type) :: beam_path_type
      !> Coordinate along the beam of the joint's second point, from which the joint's own is counted [length]
      real(wp) :: start = 0.0_wp
      !> Whether f is of the coordinate s along the beam, factor s - offset, and not of the distance from it
      logical :: of_coordinate = .false.
      real(wp) :: factor = 1.0_wp, offset = 0.0_wp
   contains
      !> Where along the beam the point is, and its rate
      procedure(coordinate_interface), deferred :: coordinate
   end type beam_path_type

   abstract interface
      pure subroutine coordinate_interface(self, z, rate, s, speed)
         import :: beam_path_type, wp
         class(beam_path_type), intent(in) :: self
         !> Variables of the joint, and their rates (2 + n)
         real(wp), intent(in) :: z(:), rate(:)
         !> Coordinate of the undeformed axis from the start of the beam [length], and its rate [length/time]
         real(wp), intent(out) :: s, speed
      end subroutine coordinate_interface
   end interface

end module limber_multibody_beam_path
