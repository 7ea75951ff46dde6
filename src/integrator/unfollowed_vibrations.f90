!> Vibrations that an implicit integrator does not follow. Their deflections are below the tolerance, their accelerations need not
!> be. Watched only where a channel asks for such. Floor: integrator. Source: doc/theory, eqs. (5.38), (5.41).
module limber_integrator_unfollowed_vibrations
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: ringing_type

   !> Most that is lost of a vibration, in parts of it: it is opposite
   real(wp), parameter :: most_lost = 2.0_wp

   !> What is remembered of the vibrations of elastic coordinates, in the layout of the rates
   type :: ringing_type
      logical :: watched = .false.
      !> Accelerations at the ends of the last two steps (nw), and how many of these there are; length of the last step [time]
      real(wp), allocatable :: last(:), before(:)
      integer :: known = 0
      real(wp) :: h_last = 0.0_wp
      !> What has been lost of each, or is kept up, and its largest vibration (nw)
      real(wp), allocatable :: lost(:), top(:)
      !> Frequency of the fastest elastic coordinate [rad/time]
      real(wp) :: fastest = 0.0_wp
   contains
      procedure :: watch, forget, note, note_limit, lost_at, lost_of, exchange => exchange_ringing
   end type ringing_type

contains

   !> Begins.
   subroutine watch(self, system)
      class(ringing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: i
      do i = 1, size(system%layout%q)
         if (system%layout%n(i) > 0) self%fastest = max(self%fastest, sqrt(max(0.0_wp, &
            & maxval(system%model%bodies(i)%reduced%omega2))))
      end do
      associate (nw => system%layout%nw)
         allocate (self%last(nw), self%before(nw), self%lost(nw), self%top(nw), source=0.0_wp)
      end associate
      self%watched = .true.
   end subroutine watch

   !> The accelerations may jump.
   pure subroutine forget(self)
      class(ringing_type), intent(inout) :: self
      self%known = 0
   end subroutine forget

   !> Takes the accelerations at the end of a step, eq. (5.38).
   pure subroutine note(self, system, h, a, factor, order)
      class(ringing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Length of the step; accelerations (nw)
      real(wp), intent(in) :: h, a(:)
      !> A step changes a vibration at omega by factor (h omega)^order of itself
      real(wp), intent(in) :: factor
      integer, intent(in) :: order
      real(wp) :: vibration, turn2
      integer :: i, k, at
      if (.not. self%watched) return
      do i = 1, size(system%layout%n)
         associate (body => system%model%bodies(i), first => system%layout%w(i), n => system%layout%n(i))
            if (self%known < 2) exit
            do k = 1, n
               at = first + 2 + k
               turn2 = h**2*body%reduced%omega2(k)
               vibration = 2*abs((a(at) - self%last(at))/h - (self%last(at) - self%before(at))/self%h_last)/(h + self%h_last)
               vibration = vibration*h**2/min(4.0_wp, turn2)
               self%lost(at) = self%lost(at) + vibration*min(1.0_wp, factor*turn2**(0.5_wp*order))
               self%top(at) = max(self%top(at), vibration)
            end do
         end associate
      end do
      self%before = self%last
      self%last = a
      self%h_last = h
      self%known = min(2, self%known + 1)
   end subroutine note

   !> Takes the accelerations at the end of a step of an explicit integrator that is at the limit of its stability, eq. (5.41):
   !> vibrations do not die away there, but are kept up as large as the tolerance lets them be.
   pure subroutine note_limit(self, system, h, a, allowed)
      class(ringing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Length of the step; accelerations (nw); error that the speed of each coordinate may have (nq)
      real(wp), intent(in) :: h, a(:), allowed(:)
      !> Local errors that add up in a vibration that is kept up: beyond, it belongs to the motion
      real(wp), parameter :: most = 300.0_wp
      integer :: i, k, at
      call self%note(system, h, a, 0.0_wp, 0)
      do i = 1, size(system%layout%n)
         do k = 1, system%layout%n(i)
            at = system%layout%w(i) + 2 + k
            self%lost(at) = max(self%lost(at), min(self%top(at), most*sqrt(system%model%bodies(i)%reduced%omega2(k)) &
               & *allowed(system%layout%q(i) + 3 + k)))
         end do
      end do
   end subroutine note_limit

   !> Acceleration that is lost of an elastic coordinate, or kept up [length/time^2 of unit modal mass].
   pure real(wp) function lost_at(self, at) result(lost)
      class(ringing_type), intent(in) :: self
      !> Its place among the rates
      integer, intent(in) :: at
      lost = min(self%lost(at), most_lost*self%top(at))
   end function lost_at

   !> The same of all, zero where a body is at rest (nw).
   pure function lost_of(self, system, least) result(lost)
      class(ringing_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Acceleration of a point of a body below which it is at rest [length/time^2]
      real(wp), intent(in) :: least
      real(wp) :: lost(size(self%lost))
      integer :: i, k, at
      lost = 0.0_wp
      do i = 1, size(system%layout%n)
         do k = 1, system%layout%n(i)
            at = system%layout%w(i) + 2 + k
            if (self%lost_at(at)*system%model%bodies(i)%largest_shape > least) lost(at) = self%lost_at(at)
         end do
      end do
   end function lost_of

   !> Saves or restores its memory.
   subroutine exchange_ringing(self, snapshot)
      class(ringing_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('ringing_last', self%last)
      call snapshot%keep('ringing_before', self%before)
      call snapshot%exchange('ringing_known', self%known)
      call snapshot%exchange('ringing_h', self%h_last)
      call snapshot%keep('ringing_lost', self%lost)
      call snapshot%keep('ringing_top', self%top)
      ! Not saved: watched, fastest
   end subroutine exchange_ringing

end module limber_integrator_unfollowed_vibrations
