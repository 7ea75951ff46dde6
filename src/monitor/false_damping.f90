!> Monitor of damping by the Coriolis force that K_G lacks. In rotation the model K_G has the tension that Coriolis forces make
!> along a bent member, but not the Coriolis force of its shortening, which would give that work back. Floor: monitor. Source:
!> doc/theory, eqs. (7.22), (7.23).
module limber_monitor_false_damping
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_elastic_forces, only: coriolis_power
   use limber_beam_reduced_body, only: reduced_type
   implicit none
   private
   public :: false_damping_type, start_false_damping, observe_false_damping, join_false_damping, lost_amplitude

   !> One flexible body
   type :: false_damping_type
      !> Sums over the states that were observed: power that is lost, squared rates and coordinates, power of the damping of the
      !> body
      real(wp) :: lost = 0.0_wp, moving = 0.0_wp, bent = 0.0_wp, damped = 0.0_wp
      !> Largest square of the coordinates, and sum of each of them (n)
      real(wp) :: most = 0.0_wp
      real(wp), allocatable :: sum(:)
      !> Coordinates that bend: the others vibrate quickly, along members (n)
      logical, allocatable :: bends(:)
      !> First and last time; number of states
      real(wp) :: span(2) = [huge(1.0_wp), -huge(1.0_wp)]
      integer :: looks = 0
      !> Scratch (n), (pairs)
      real(wp), allocatable :: room(:), s(:)
   contains
      procedure :: exchange => exchange_false_damping
   end type false_damping_type

contains

   !> Before the first state; nothing is watched of a model without tension.
   pure subroutine start_false_damping(self, reduced)
      type(false_damping_type), intent(out) :: self
      type(reduced_type), intent(in) :: reduced
      !> Part of the largest slope of unit energy below which a coordinate does not bend
      real(wp), parameter :: little = 1.0e-4_wp
      real(wp) :: slope(reduced%n)
      integer :: k
      if (.not. reduced%geometric .or. reduced%is_exact) return
      allocate (self%sum(reduced%n), self%room(reduced%n), self%s(size(reduced%cubic, 1)))
      self%sum = 0.0_wp
      slope = 0.0_wp
      do k = 1, reduced%bending
         slope(k) = norm2(reduced%cubic(k*(k + 1)/2, :))/reduced%omega2(k)
      end do
      allocate (self%bends, source=slope > little*maxval(slope))
   end subroutine start_false_damping

   !> Takes a state.
   pure subroutine observe_false_damping(self, reduced, t, omega, eta, rate)
      type(false_damping_type), intent(inout) :: self
      type(reduced_type), intent(in) :: reduced
      !> Time, angular velocity of the frame, coordinates and their rates (n)
      real(wp), intent(in) :: t, omega, eta(:), rate(:)
      real(wp) :: power
      integer :: k
      if (.not. allocated(self%sum)) return
      call coriolis_power(reduced, omega, eta, rate, self%room, self%s, power)
      self%lost = self%lost + power
      self%moving = self%moving + sum(rate**2, mask=self%bends)
      self%bent = self%bent + dot_product(eta, eta)
      self%most = max(self%most, dot_product(eta, eta))
      self%sum = self%sum + eta
      if (reduced%damped) then
         do k = 1, reduced%n
            if (self%bends(k)) self%damped = self%damped + rate(k)*dot_product(reduced%damping(:, k), rate)
         end do
      end if
      self%span = [min(self%span(1), t), max(self%span(2), t)]
      self%looks = self%looks + 1
   end subroutine observe_false_damping

   !> What a vibration has lost, or gained, of its amplitude in the end, relative to the largest deflection, eq. (7.23). Deflections
   !> that follow slowly changing loads do not vibrate.
   pure real(wp) function lost_amplitude(self, first_frequency) result(lost)
      type(false_damping_type), intent(in) :: self
      !> Of the body
      real(wp), intent(in) :: first_frequency
      !> Largest logarithm of an amplitude that is told; the one below which a decay is linear
      real(wp), parameter :: most = 20.0_wp, small = 1.0e-8_wp
      real(wp) :: spread, free, time, decay, gain
      lost = 0.0_wp
      if (self%looks < 2 .or. .not. (self%moving > 0.0_wp .and. self%most > 0.0_wp)) return
      spread = max(0.0_wp, self%bent - dot_product(self%sum, self%sum)/self%looks)
      if (.not. spread > 0.0_wp) return
      ! Quotients of what has hardly moved would overflow
      free = 1.0_wp
      if (self%moving < first_frequency**2*spread) free = self%moving/(first_frequency**2*spread)
      time = self%span(2) - self%span(1)
      if (self%damped*time > 2*self%moving) time = 2*self%moving/self%damped
      decay = most
      if (0.5_wp*time*abs(self%lost) < most*self%moving) decay = 0.5_wp*time*abs(self%lost)/self%moving
      ! The sums are means over what decays
      gain = 1.0_wp
      if (decay > small) gain = 2*decay/(1 - exp(-2*decay))
      lost = (1 - exp(-decay))*free*min(1.0_wp, sqrt(2*spread/self%looks/self%most*gain))
   end function lost_amplitude

   !> Joins what an analysis saw to what the ones before it did.
   pure subroutine join_false_damping(part, whole)
      type(false_damping_type), intent(in) :: part
      type(false_damping_type), intent(inout) :: whole
      if (.not. allocated(part%sum)) return
      whole%lost = whole%lost + part%lost
      whole%moving = whole%moving + part%moving
      whole%bent = whole%bent + part%bent
      whole%damped = whole%damped + part%damped
      whole%most = max(whole%most, part%most)
      whole%sum = whole%sum + part%sum
      whole%span = [min(whole%span(1), part%span(1)), max(whole%span(2), part%span(2))]
      whole%looks = whole%looks + part%looks
   end subroutine join_false_damping

   !> Saves or restores its memory.
   subroutine exchange_false_damping(self, snapshot)
      class(false_damping_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('lost', self%lost)
      call snapshot%exchange('moving', self%moving)
      call snapshot%exchange('bent', self%bent)
      call snapshot%exchange('damped', self%damped)
      call snapshot%exchange('most', self%most)
      call snapshot%keep('sum', self%sum)
      call snapshot%exchange('span', self%span)
      call snapshot%exchange('looks', self%looks)
      ! Not saved: bends, room, s
   end subroutine exchange_false_damping

end module limber_monitor_false_damping
