!> What accelerations, reactions and section forces lose of vibrations that an implicit integrator does not follow: their
!> deflections are below the tolerance, their accelerations need not be. Watched only where a channel asks for such.
!> Floor: integrator.
!> Source: doc/theory, eqs. (W4), (Z1).
module limber_integrator_ringing
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_system_system, only: system_type
   implicit none
   private
   public :: ringing_type

   !> What is remembered of the vibrations of elastic coordinates, in the layout of the rates
   type :: ringing_type
      logical :: watched = .false.
      !> Accelerations at the ends of the last two steps (nw), and how many of these there are; length of the last step [time]
      real(wp), allocatable :: last(:), before(:)
      integer :: known = 0
      real(wp) :: h_last = 0.0_wp
      !> What has been lost of each, and its largest vibration (nw); largest acceleration of each body (bodies)
      real(wp), allocatable :: lost(:), top(:), scale(:)
      !> Where an explicit integrator keeps vibrations up: largest acceleration of each, or what its deflection stands for (nw)
      real(wp), allocatable :: own(:)
      !> Frequency of the fastest elastic coordinate [rad/time]
      real(wp) :: fastest = 0.0_wp
   contains
      procedure :: watch, forget, note, note_limit, worst, exchange => exchange_ringing
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
         allocate (self%last(nw), self%before(nw), self%lost(nw), self%top(nw), self%own(nw), &
            & self%scale(size(system%layout%q)), source=0.0_wp)
      end associate
      self%watched = .true.
   end subroutine watch

   !> The accelerations may jump.
   pure subroutine forget(self)
      class(ringing_type), intent(inout) :: self
      self%known = 0
   end subroutine forget

   !> Takes the accelerations at the end of a step, eq. (W4).
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
      do i = 1, size(self%scale)
         associate (body => system%model%bodies(i), first => system%layout%w(i), n => system%layout%n(i))
            if (n == 0) cycle
            self%scale(i) = max(self%scale(i), abs(a(first)), abs(a(first + 1)), abs(a(first + 2))*body%size, &
               & maxval(abs(a(first + 3:first + 2 + n)))*body%largest_shape)
            if (self%known < 2) cycle
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

   !> Takes the accelerations at the end of a step of an explicit integrator that may be at the limit of its stability, eq. (Z1):
   !> vibrations do not die away there, but are kept up as large as the tolerance lets them be.
   pure subroutine note_limit(self, system, is_limit, h, q, a, allowed)
      class(ringing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Whether it is there: else only the size of what moves is noted
      logical, intent(in) :: is_limit
      !> Length of the step; coordinates (nq), accelerations (nw); error that the speed of each coordinate may have (nq)
      real(wp), intent(in) :: h, q(:), a(:), allowed(:)
      !> Local errors that add up in a vibration that is kept up: beyond, it belongs to the motion
      real(wp), parameter :: most = 300.0_wp
      real(wp) :: omega
      integer :: i, k, at, from
      if (is_limit) call self%note(system, h, a, 0.0_wp, 0)
      do i = 1, size(self%scale)
         associate (body => system%model%bodies(i), first => system%layout%w(i), n => system%layout%n(i))
            if (n == 0) cycle
            self%scale(i) = max(self%scale(i), abs(a(first)), abs(a(first + 1)), abs(a(first + 2))*body%size)
            do k = 1, n
               at = first + 2 + k
               from = system%layout%q(i) + 3 + k
               omega = sqrt(body%reduced%omega2(k))
               ! At rest loads do not accelerate, but deflect
               self%own(at) = max(self%own(at), abs(a(at)) - self%top(at), omega**2*abs(q(from)))
               self%scale(i) = max(self%scale(i), body%largest_shape*self%own(at))
               if (is_limit) self%lost(at) = max(self%lost(at), min(self%top(at), most*omega*allowed(from)))
            end do
         end associate
      end do
   end subroutine note_limit

   !> The body whose accelerations have lost most.
   pure subroutine worst(self, system, least, body, share, size_of, omega)
      class(ringing_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Acceleration below which a body counts as at rest [length/time^2]
      real(wp), intent(in) :: least
      !> Its index; 0: none
      integer, intent(out) :: body
      !> Part of its largest acceleration, the acceleration lost [length/time^2]; frequency of the vibration [rad/time]
      real(wp), intent(out) :: share, size_of, omega
      !> Part of the body's acceleration that one of its coordinates counts as at least
      real(wp), parameter :: little = 0.1_wp
      real(wp) :: lost, scale
      integer :: i, k, at
      body = 0
      share = 0.0_wp
      size_of = 0.0_wp
      omega = 0.0_wp
      if (.not. self%watched) return
      do i = 1, size(self%scale)
         do k = 1, system%layout%n(i)
            at = system%layout%w(i) + 2 + k
            scale = self%scale(i)
            if (self%own(at) > 0.0_wp) scale = max(system%model%bodies(i)%largest_shape*self%own(at), little*scale)
            lost = min(self%lost(at), 2*self%top(at))*system%model%bodies(i)%largest_shape
            scale = max(scale, least, tiny(lost))
            if (.not. lost > share*scale) cycle
            body = i
            share = lost/scale
            size_of = lost
            omega = sqrt(system%model%bodies(i)%reduced%omega2(k))
         end do
      end do
   end subroutine worst

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
      call snapshot%keep('ringing_scale', self%scale)
      call snapshot%keep('ringing_own', self%own)
   end subroutine exchange_ringing

end module limber_integrator_ringing
