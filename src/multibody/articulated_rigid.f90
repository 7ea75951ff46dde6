!> Articulated-body recursion for rigid bodies. A body costs the same in the longest chain, and nothing is factored. The bodies'
!> numbers stand in arrays in the order of the recursion, so that ten thousand bodies stream through the cache. Gives what the
!> multiplier system gives, to round-off. Floor: multibody. Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7;
!> doc/theory, eqs. (4.19)-(4.23).
module limber_multibody_articulated_rigid
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_model, only: body_rigid
   use limber_multibody_articulated, only: hinge_points
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: articulated_rigid_type, new_recursion, recursive_accelerations, recursive_settle

   !> A forest of rigid bodies; all arrays are over places: the bodies, each behind the one that carries it
   type :: articulated_rigid_type
      !> True if the model is such a forest
      logical :: usable = .false.
      !> First index of the coordinates of a body, and place of its carrier: 0 for the ground, -1 for none
      integer, allocatable :: first(:), carrier(:)
      !> Mass; first moment (2) and second moment of mass about the pin; place of the pin in the body frame (2), and from the pin
      !> of the carrier in that one's frame, or in space (2)
      real(wp), allocatable, private :: constants(:, :)
      !> Mass matrix of what hangs on a pin, [A11, A12, A22, b1, b2, I], and force [p1, p2, m], eq. (4.19)
      real(wp), allocatable, private :: articulated(:, :)
      !> Acceleration of the pin (2) and angular acceleration; or place and velocity of the pin (2, 2)
      real(wp), allocatable, private :: motion(:, :)
   contains
      procedure :: exchange => exchange_recursion
   end type articulated_rigid_type

   !> Rows of `constants`
   integer, parameter :: mass = 1, moment = 2, inertia = 4, own = 5, arm = 7

contains

   !> The forest of a system, if it is one: rigid bodies with inertia, pins that close no loop, no loads but weight.
   subroutine new_recursion(system, recursion)
      type(system_type), intent(in) :: system
      type(articulated_rigid_type), intent(out) :: recursion
      integer :: bodies, i, k
      bodies = size(system%model%bodies)
      if (.not. system%tree%articulated .or. size(system%loads) > 0 .or. system%powered) return
      do i = 1, bodies
         if (system%model%bodies(i)%kind /= body_rigid .or. .not. system%model%bodies(i)%reduced%mass > 0.0_wp) return
      end do
      recursion%carrier = system%tree%span%carrier
      recursion%first = system%layout%q(system%tree%span%body)
      allocate (recursion%constants(8, bodies), recursion%articulated(9, bodies), recursion%motion(4, bodies))
      do k = 1, bodies
         call set_constants(system, k, recursion)
      end do
      recursion%usable = all(recursion%constants(inertia, :) > 0.0_wp)
   end subroutine new_recursion

   !> Constants of a place; those of its carrier are there.
   subroutine set_constants(system, k, recursion)
      type(system_type), intent(in) :: system
      integer, intent(in) :: k
      type(articulated_rigid_type), intent(inout) :: recursion
      real(wp) :: p(2), base(2)
      integer :: points(2)
      p = 0.0_wp
      base = 0.0_wp
      if (recursion%carrier(k) >= 0) then
         points = hinge_points(system, k)
         p = system%model%points(points(1))%p0
         base = system%model%points(points(2))%p0
         if (recursion%carrier(k) > 0) base = base - recursion%constants(own:own + 1, recursion%carrier(k))
      end if
      associate (body => system%model%bodies(system%tree%span%body(k))%reduced, to => recursion%constants(:, k))
         to(mass) = body%mass
         to(moment:moment + 1) = body%c0 - body%mass*p
         to(inertia) = body%i0 - 2*dot_product(body%c0, p) + body%mass*dot_product(p, p)
         to(own:own + 1) = p
         to(arm:arm + 1) = base
      end associate
   end subroutine set_constants

   !> Accelerations, eqs. (4.19)-(4.22). Of q and v only the frames' vectors and their rates matter.
   pure subroutine recursive_accelerations(recursion, gravity, q, v, a)
      type(articulated_rigid_type), intent(inout) :: recursion
      !> Acceleration of gravity (2) [length/time^2]
      real(wp), intent(in) :: gravity(2)
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> Second derivatives of q (nq)
      real(wp), contiguous, intent(inout) :: a(:)
      integer :: k
      do k = 1, size(recursion%first)
         associate (at => recursion%first(k))
            call start_place(recursion%constants(:, k), gravity, q(at + 2:at + 3), v(at + 2:at + 3), recursion%articulated(:, k))
         end associate
      end do
      do k = size(recursion%first), 1, -1
         if (recursion%carrier(k) <= 0) cycle
         associate (at => recursion%first(recursion%carrier(k)))
            call hand_on(recursion%constants(:, k), recursion%articulated(:, k), q(at + 2:at + 3), v(at + 2:at + 3), &
               & recursion%articulated(:, recursion%carrier(k)))
         end associate
      end do
      do k = 1, size(recursion%first)
         associate (at => recursion%first(k), c => recursion%carrier(k))
            if (c > 0) then
               associate (from => recursion%first(c))
                  call carry(recursion%constants(:, k), q(from + 2:from + 3), v(from + 2:from + 3), recursion%motion(:, c), &
                     & recursion%motion(:, k))
               end associate
            else
               call let_go(c < 0, recursion%articulated(:, k), recursion%motion(:, k))
            end if
            call finish_place(recursion%constants(:, k), recursion%articulated(:, k), q(at + 2:at + 3), v(at + 2:at + 3), &
               & recursion%motion(:, k), a(at:at + 3))
         end associate
      end do
   end subroutine recursive_accelerations

   !> Mass matrix and forces of a body alone, about its pin.
   pure subroutine start_place(constants, gravity, u, rate, to)
      real(wp), intent(in) :: constants(8), gravity(2), u(2), rate(2)
      real(wp), intent(out) :: to(9)
      real(wp) :: c(2), omega
      c(1) = constants(moment)*u(1) - constants(moment + 1)*u(2)
      c(2) = constants(moment)*u(2) + constants(moment + 1)*u(1)
      omega = u(1)*rate(2) - u(2)*rate(1)
      to(1) = constants(mass)
      to(2) = 0.0_wp
      to(3) = constants(mass)
      to(4) = -c(2)
      to(5) = c(1)
      to(6) = constants(inertia)
      to(7) = constants(mass)*gravity(1) + omega**2*c(1)
      to(8) = constants(mass)*gravity(2) + omega**2*c(2)
      to(9) = c(1)*gravity(2) - c(2)*gravity(1)
   end subroutine start_place

   !> Adds to the carrier what hangs on it, its rotation about the pin eliminated: eqs. (4.20), (4.21).
   pure subroutine hand_on(constants, from, u, rate, to)
      !> Of the place that hangs
      real(wp), intent(in) :: constants(8), from(9)
      !> Vector of the carrier's frame and its rate
      real(wp), intent(in) :: u(2), rate(2)
      real(wp), intent(inout) :: to(9)
      real(wp) :: inverse, a11, a12, a22, force(2), d(2), w(2), omega
      inverse = 1/from(6)
      a11 = from(1) - from(4)*from(4)*inverse
      a12 = from(2) - from(4)*from(5)*inverse
      a22 = from(3) - from(5)*from(5)*inverse
      d(1) = constants(arm)*u(1) - constants(arm + 1)*u(2)
      d(2) = constants(arm)*u(2) + constants(arm + 1)*u(1)
      omega = u(1)*rate(2) - u(2)*rate(1)
      force(1) = from(7) - from(4)*from(9)*inverse + omega**2*(a11*d(1) + a12*d(2))
      force(2) = from(8) - from(5)*from(9)*inverse + omega**2*(a12*d(1) + a22*d(2))
      w(1) = -a11*d(2) + a12*d(1)
      w(2) = -a12*d(2) + a22*d(1)
      to(1) = to(1) + a11
      to(2) = to(2) + a12
      to(3) = to(3) + a22
      to(4) = to(4) + w(1)
      to(5) = to(5) + w(2)
      to(6) = to(6) - d(2)*w(1) + d(1)*w(2)
      to(7) = to(7) + force(1)
      to(8) = to(8) + force(2)
      to(9) = to(9) - d(2)*force(1) + d(1)*force(2)
   end subroutine hand_on

   !> Acceleration of a pin on a carrier.
   pure subroutine carry(constants, u, rate, from, to)
      real(wp), intent(in) :: constants(8), u(2), rate(2), from(4)
      real(wp), intent(inout) :: to(4)
      real(wp) :: d(2), omega
      d(1) = constants(arm)*u(1) - constants(arm + 1)*u(2)
      d(2) = constants(arm)*u(2) + constants(arm + 1)*u(1)
      omega = u(1)*rate(2) - u(2)*rate(1)
      to(1) = from(1) - from(3)*d(2) - omega**2*d(1)
      to(2) = from(2) + from(3)*d(1) - omega**2*d(2)
   end subroutine carry

   !> Acceleration of a pin on the ground, or of the origin of a body that hangs on nothing.
   pure subroutine let_go(free, from, to)
      logical, intent(in) :: free
      real(wp), intent(in) :: from(9)
      real(wp), intent(inout) :: to(4)
      real(wp) :: inverse, a11, a12, a22, force(2), determinant
      to(1:2) = 0.0_wp
      if (.not. free) return
      inverse = 1/from(6)
      a11 = from(1) - from(4)*from(4)*inverse
      a12 = from(2) - from(4)*from(5)*inverse
      a22 = from(3) - from(5)*from(5)*inverse
      force = from(7:8) - from(4:5)*from(9)*inverse
      determinant = a11*a22 - a12*a12
      to(1) = (a22*force(1) - a12*force(2))/determinant
      to(2) = (a11*force(2) - a12*force(1))/determinant
   end subroutine let_go

   !> Angular acceleration, and the second derivatives of a body's coordinates: eq. (4.22).
   pure subroutine finish_place(constants, from, u, rate, motion, a)
      real(wp), intent(in) :: constants(8), from(9), u(2), rate(2)
      real(wp), intent(inout) :: motion(4)
      real(wp), intent(inout) :: a(4)
      real(wp) :: e(2), omega, alpha, square
      alpha = (from(9) - from(4)*motion(1) - from(5)*motion(2))/from(6)
      motion(3) = alpha
      e(1) = constants(own)*u(1) - constants(own + 1)*u(2)
      e(2) = constants(own)*u(2) + constants(own + 1)*u(1)
      omega = u(1)*rate(2) - u(2)*rate(1)
      square = rate(1)**2 + rate(2)**2
      a(1) = motion(1) + alpha*e(2) + omega**2*e(1)
      a(2) = motion(2) - alpha*e(1) + omega**2*e(2)
      a(3) = -alpha*u(2) - square*u(1)
      a(4) = alpha*u(1) - square*u(2)
   end subroutine finish_place

   !> Brings the frames' vectors to unit length and puts every body on its pin, at position and velocity level: eq. (4.23).
   pure subroutine recursive_settle(recursion, q, v)
      type(articulated_rigid_type), intent(inout) :: recursion
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      real(wp) :: u(2), d(2), e(2), omega, length, above(2), turning
      integer :: k, at, c
      do k = 1, size(recursion%first)
         at = recursion%first(k)
         c = recursion%carrier(k)
         length = sqrt(q(at + 2)**2 + q(at + 3)**2)
         u = q(at + 2:at + 3)/length
         omega = u(1)*v(at + 3) - u(2)*v(at + 2)
         q(at + 2:at + 3) = u
         v(at + 2) = -omega*u(2)
         v(at + 3) = omega*u(1)
         associate (constants => recursion%constants(:, k), pin => recursion%motion(:, k))
            if (c < 0) then
               pin(1:2) = q(at:at + 1)
               pin(3:4) = v(at:at + 1)
               cycle
            else if (c == 0) then
               pin(1:2) = constants(arm:arm + 1)
               pin(3:4) = 0.0_wp
            else
               associate (from => recursion%first(c), carrier => recursion%motion(:, c))
                  above = q(from + 2:from + 3)
                  turning = above(1)*v(from + 3) - above(2)*v(from + 2)
                  d(1) = constants(arm)*above(1) - constants(arm + 1)*above(2)
                  d(2) = constants(arm)*above(2) + constants(arm + 1)*above(1)
                  pin(1:2) = carrier(1:2) + d
                  pin(3) = carrier(3) - turning*d(2)
                  pin(4) = carrier(4) + turning*d(1)
               end associate
            end if
            e(1) = constants(own)*u(1) - constants(own + 1)*u(2)
            e(2) = constants(own)*u(2) + constants(own + 1)*u(1)
            q(at:at + 1) = pin(1:2) - e
            v(at) = pin(3) + omega*e(2)
            v(at + 1) = pin(4) - omega*e(1)
         end associate
      end do
   end subroutine recursive_settle

   !> Saves or restores its memory.
   subroutine exchange_recursion(self, snapshot)
      class(articulated_rigid_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('articulated', self%articulated)
      call snapshot%keep('motion', self%motion)
      ! Not saved: usable, first, carrier, constants
   end subroutine exchange_recursion

end module limber_multibody_articulated_rigid
