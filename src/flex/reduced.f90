!> A body reduced to its constants: inertia invariants, squared frequencies and the projected geometric part.
!> All that the time loop ever sees of a body; a rigid body is one with n = 0. Floor: flex. Source: doc/theory, eqs. (8), (22).
module limber_flex_reduced
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: reduced_type, rigid_reduced, add_inertia

   !> Constants of a body. Its coordinates eta (n) are mass-normalised, the bending ones first, then the axial.
   type :: reduced_type
      !> Number of coordinates eta, and how many of them are bending
      integer :: n = 0, bending = 0
      !> Mass [mass]
      real(wp) :: mass = 0.0_wp
      !> First moment of mass, sum m p0 [mass length]
      real(wp) :: c0(2) = 0.0_wp
      !> Second moment of mass about the frame's origin, sum m |p0|^2 [mass length^2]
      real(wp) :: i0 = 0.0_wp
      !> C (2,n) = sum m phi
      real(wp), allocatable :: c(:, :)
      !> d (n) = sum m p0.phi_j and e (n) = sum m p0 x phi_j
      real(wp), allocatable :: d(:), e(:)
      !> E (n,n) = sum m phi_j x phi_k, skew
      real(wp), allocatable :: skew(:, :)
      !> Diagonal of K_E: squared circular frequencies (n) [1/time^2]
      real(wp), allocatable :: omega2(:)
      !> True if tension acts on the bending (models k_g and full)
      logical :: geometric = .false.
      !> True if the geometric part is the gradient of an energy (model full)
      logical :: full = .false.
      !> True if the coordinates are damped, each by itself, and the factors of their rates then (n) [1/time]
      logical :: damped = .false.
      real(wp), allocatable :: damping(:)
      !> Geometric part (pairs, n - bending) and (pairs, pairs), pairs = bending (bending + 1)/2; see limber_flex_geometric
      real(wp), allocatable :: cubic(:, :), quartic(:, :)
   end type reduced_type

contains

   !> A rigid body.
   pure function rigid_reduced(mass, inertia, centre) result(body)
      !> Mass [mass], moment of inertia about the centre of mass [mass length^2]
      real(wp), intent(in) :: mass, inertia
      !> Centre of mass in the body frame (2) [length]
      real(wp), intent(in) :: centre(2)
      type(reduced_type) :: body
      body%mass = mass
      body%c0 = mass*centre
      body%i0 = inertia + mass*dot_product(centre, centre)
      allocate (body%c(2, 0), body%d(0), body%e(0), body%skew(0, 0), body%omega2(0), body%cubic(0, 0), body%quartic(0, 0))
   end function rigid_reduced

   !> Adds one lumped mass to the inertia invariants.
   pure subroutine add_inertia(body, mass, p0, phi)
      type(reduced_type), intent(inout) :: body
      !> Mass of the node [mass]
      real(wp), intent(in) :: mass
      !> Its undeformed place in the body frame (2) [length]
      real(wp), intent(in) :: p0(2)
      !> Its displacement for each coordinate (2,n)
      real(wp), intent(in) :: phi(:, :)
      integer :: k
      body%mass = body%mass + mass
      body%c0 = body%c0 + mass*p0
      body%i0 = body%i0 + mass*dot_product(p0, p0)
      body%c = body%c + mass*phi
      body%d = body%d + mass*(p0(1)*phi(1, :) + p0(2)*phi(2, :))
      body%e = body%e + mass*(p0(1)*phi(2, :) - p0(2)*phi(1, :))
      do k = 1, body%n
         body%skew(:, k) = body%skew(:, k) + mass*(phi(1, :)*phi(2, k) - phi(2, :)*phi(1, k))
      end do
   end subroutine add_inertia

end module limber_flex_reduced
