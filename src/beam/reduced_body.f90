!> Constants of a reduced body: inertia invariants, frequencies, geometric part. All that the time loop ever sees of a body; a rigid
!> body is one with n = 0. Floor: beam. Source: doc/theory, eqs. (1.8), (2.8).
module limber_beam_reduced_body
   use limber_base_kinds, only: wp, long
   use limber_beam_exact_beam, only: exact_type
   implicit none
   private
   public :: add_damping, damping_power
   public :: reduced_type, rigid_reduced, start_inertia, add_inertia, add_rotary, rotary_row, rotary_square, bytes_of

   !> Constants of a body. Its coordinates eta (n) are mass-normalised. Those of a straight beam bend it first, then stretch it;
   !> those of a frame do both.
   type :: reduced_type
      !> Number of coordinates eta, and how many of them are bending
      integer :: n = 0, bending = 0
      !> Number of its first coordinates, of a beam those of bending, that are vibration modes; others are static functions
      integer :: modes = 0
      !> Number of coordinates before the first that carries tension: `bending` of a straight beam, 0 of a frame
      integer :: offset = 0
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
      !> True if nodes have a rotary inertia J; then R (n,n) = sum J psi psi^T, otherwise (0,0)
      logical :: spinning = .false.
      real(wp), allocatable :: rotary(:, :)
      !> Diagonal of K_E: squared circular frequencies (n) [1/time^2]
      real(wp), allocatable :: omega2(:)
      !> True if tension acts on the bending (model k_g)
      logical :: geometric = .false.
      !> True if the coordinates are damped, and the factors of their rates then, symmetric (n, n) [1/time]
      logical :: damped = .false.
      real(wp), allocatable :: damping(:, :)
      !> Geometric part (pairs, n - offset), pairs = bending (bending + 1)/2; see limber_beam_geometric_stiffness
      real(wp), allocatable :: cubic(:, :)
      !> True of an exact beam, and its constants: then the mass matrix changes with the coordinates, and the invariants above are
      !> those of the undeformed beam
      logical :: is_exact = .false.
      type(exact_type), allocatable :: exact
      !> True if heat or tension strains it: then its energy is zero at the coordinates `rest` of the exact beam
      logical :: strained = .false.
   end type reduced_type

contains

   !> Memory that the constants of a body take [bytes].
   pure integer(long) function bytes_of(body)
      type(reduced_type), intent(in) :: body
      bytes_of = 8*(7_long*body%n + size(body%skew, kind=long) + size(body%rotary, kind=long) + size(body%cubic, kind=long))
   end function bytes_of

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
      allocate (body%c(2, 0), body%d(0), body%e(0), body%skew(0, 0), body%omega2(0), body%cubic(0, 0))
      allocate (body%rotary(0, 0))
   end function rigid_reduced

   !> Inertia invariants of a body without mass.
   pure subroutine start_inertia(body, n)
      type(reduced_type), intent(inout) :: body
      !> Number of its coordinates
      integer, intent(in) :: n
      body%n = n
      allocate (body%c(2, n), body%d(n), body%e(n), body%skew(n, n), body%rotary(0, 0))
      body%c = 0.0_wp
      body%d = 0.0_wp
      body%e = 0.0_wp
      body%skew = 0.0_wp
   end subroutine start_inertia

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

   !> Adds the inertia of a node that turns with its section, eq. (1.12).
   pure subroutine add_rotary(body, inertia, psi)
      type(reduced_type), intent(inout) :: body
      !> Moment of inertia about the node [mass length^2]
      real(wp), intent(in) :: inertia
      !> Rotation of the section for each coordinate (n)
      real(wp), intent(in) :: psi(:)
      integer :: k
      if (.not. body%spinning) then
         deallocate (body%rotary)
         allocate (body%rotary(body%n, body%n))
         body%rotary = 0.0_wp
         body%spinning = .true.
      end if
      body%i0 = body%i0 + inertia
      body%e = body%e + inertia*psi
      do k = 1, body%n
         body%rotary(:, k) = body%rotary(:, k) + inertia*psi*psi(k)
      end do
   end subroutine add_rotary

   !> Adds the damping, times a factor, to forces on the coordinates; of a damped body only.
   pure subroutine add_damping(body, factor, rate, force)
      type(reduced_type), intent(in) :: body
      !> Of the damping; rates of the coordinates (n)
      real(wp), intent(in) :: factor, rate(:)
      !> (n)
      real(wp), intent(inout) :: force(:)
      integer :: j, k
      do k = 1, body%n
         do j = 1, body%n
            force(j) = force(j) + factor*body%damping(j, k)*rate(k)
         end do
      end do
   end subroutine add_damping

   !> Power that the damping takes; of a damped body only.
   pure real(wp) function damping_power(body, rate) result(power)
      type(reduced_type), intent(in) :: body
      !> Rates of the coordinates (n)
      real(wp), intent(in) :: rate(:)
      integer :: k
      power = 0.0_wp
      do k = 1, body%n
         power = power + rate(k)*dot_product(body%damping(:, k), rate)
      end do
   end function damping_power

   !> eta.R eta; of a spinning body only.
   pure real(wp) function rotary_square(body, eta) result(square)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      integer :: k
      square = 0.0_wp
      do k = 1, body%n
         square = square + eta(k)*rotary_row(body, k, eta)
      end do
   end function rotary_square

   !> Row k of R times eta; of a spinning body only.
   pure real(wp) function rotary_row(body, k, eta) result(part)
      type(reduced_type), intent(in) :: body
      integer, intent(in) :: k
      real(wp), intent(in) :: eta(:)
      integer :: j
      part = 0.0_wp
      do j = 1, body%n
         part = part + body%rotary(j, k)*eta(j)
      end do
   end function rotary_row

end module limber_beam_reduced_body
