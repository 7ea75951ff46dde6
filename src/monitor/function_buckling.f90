!> Monitor of exact beams that stay straight under a buckling load. Then its buckling begins with round-off, and the instant at
!> which it shows says nothing. A beam that bends, however little, follows its equations. Floor: monitor. Source: doc/theory, part
!> 2, eqs. (7.68), (7.69).
module limber_monitor_function_buckling
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_monitor_connections, only: hangs_on, ends_of
   use limber_model_model, only: place_on_beam, place_rolling, model_type
   implicit none
   private
   public :: buckling_type, start_buckling, observe_buckling, join_buckling, buckles_unseen

   !> Compression beyond which it counts, in units of Euler's load; deflection that is none, in units of the length; growth by
   !> which a
   !> small imperfection becomes large, as a logarithm
   real(wp), parameter :: beyond = 1.05_wp, straight = 1.0e-10_wp, much = 2.0_wp

   !> One beam, or a piece of one
   type :: buckling_type
      !> Euler's load [force], as it is and as if the ends that carry something stood still; 0: none that could be told of.
      !> Squares of
      !> the rates at which a deflection grows, for each unit of force beyond these [1/(mass length)]
      real(wp) :: euler = 0.0_wp, euler_between = 0.0_wp, pace = 0.0_wp, pace_between = 0.0_wp
      !> Compression at the last state in motion in units of Euler's load, and when; largest one while it was straight, and when;
      !> growth of a deflection so far, as a logarithm
      real(wp) :: last = 0.0_wp, last_time = huge(1.0_wp), worst = 0.0_wp, when = 0.0_wp, growth = 0.0_wp
   contains
      procedure :: exchange => exchange_buckling
   end type buckling_type

contains

   !> Euler's load as joints hold the ends; what hangs on the beam alone holds nothing. Eq. (7.68).
   subroutine start_buckling(self, model, body)
      type(buckling_type), intent(out) :: self
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      !> Of beams held at both ends, with none, one and two of them clamped, in units of E I pi^2/L^2
      real(wp), parameter :: pi = acos(-1.0_wp), of_clamps(0:2) = [1.0_wp, 2.046_wp, 4.0_wp]
      real(wp) :: carried(2), factor
      logical :: held(2), clamped(2)
      associate (exact => model%bodies(body)%reduced%exact, support => model%bodies(body)%choice%exact%support, &
         & beam => model%bodies(body)%beam)
         ! A curved axis bends at once
         if (abs(exact%arc) > 0.0_wp) return
         held = [support%w_start, support%w_end]
         clamped = [support%theta_start, support%theta_end]
         carried = 0.0_wp
         if (model%bodies(body)%whole > 0) then
            held = .true.
            clamped = .false.
         else
            call find_carried(model, body, held, clamped, carried)
         end if
         factor = 0.0_wp
         if (all(held)) factor = of_clamps(count(clamped))
         if (count(held) == 1) factor = merge(merge(1.0_wp, 0.25_wp, all(clamped)), 0.0_wp, any(held .and. clamped))
         self%euler = factor*pi**2*beam%ei/exact%total**2
         self%euler_between = of_clamps(count(clamped))*pi**2*beam%ei/exact%total**2
         self%pace_between = pi**2/(exact%total*beam%rho_a*exact%total)
         self%pace = self%pace_between
         if (.not. all(held)) self%pace = 1.2_wp/(exact%total*(sum(carried) + 0.24_wp*beam%rho_a*exact%total))
      end associate
   end subroutine start_buckling

   !> Ends at which joints connect the beam with nothing but what hangs on it, and the mass of that.
   subroutine find_carried(model, body, held, clamped, carried)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      !> Of the start and the end
      logical, intent(inout) :: held(2), clamped(2)
      real(wp), intent(out) :: carried(2)
      logical :: found(2), firm(2), guided(2)
      integer :: i, side, ends(2), end
      found = .false.
      firm = .false.
      guided = .false.
      carried = 0.0_wp
      do i = 1, size(model%joints)
         if (any(model%joints(i)%place == [place_rolling, place_on_beam])) cycle
         ends = ends_of(model, i)
         do side = 1, 2
            if (ends(side) /= body .or. model%joints(i)%points(side) == 0) cycle
            end = end_of(model, body, model%joints(i)%points(side))
            if (end == 0) cycle
            found(end) = .true.
            if (.not. model%joints(i)%bears(side) .or. (hangs_on(model, ends(3 - side), [body]) .and. &
               & .not. model%joints(i)%is_weld())) then
               guided(end) = guided(end) .or. model%joints(i)%guides(side)
               carried(end) = carried(end) + model%bodies(ends(3 - side))%reduced%mass
            else
               firm(end) = .true.
            end if
         end do
      end do
      where (found .and. .not. firm)
         held = .false.
         clamped = guided
      end where
   end subroutine find_carried

   !> 1 for a point at the start of a beam, 2 at its end, 0 between.
   pure integer function end_of(model, body, point)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body, point
      real(wp), parameter :: near = 1.0e-6_wp
      real(wp) :: s
      associate (own => model%bodies(body))
         s = (model%points(point)%p0(1) + own%choice%exact%origin)/own%reduced%exact%total
      end associate
      end_of = 0
      if (abs(s) < near) end_of = 1
      if (abs(s - 1) < near) end_of = 2
   end function end_of

   !> Takes in a state in motion, eq. (7.69).
   pure subroutine observe_buckling(self, t, push, across, length)
      type(buckling_type), intent(inout) :: self
      !> Time; mean compression [force]; largest deflection and length of the beam
      real(wp), intent(in) :: t, push, across, length
      real(wp) :: now
      if (.not. self%euler > 0.0_wp) return
      now = push/self%euler
      if (across > straight*length) now = 0.0_wp
      ! It stays straight from one state to the next
      if (t > self%last_time .and. min(now, self%last) > 0.0_wp) self%growth = self%growth + (t - self%last_time)* &
         & 0.5_wp*(rate(now) + rate(self%last))
      if (now > self%worst) then
         self%worst = now
         self%when = t
      end if
      self%last = now
      self%last_time = t

   contains

      pure real(wp) function rate(load)
         real(wp), intent(in) :: load
         rate = sqrt(max(0.0_wp, self%pace*(load - 1)*self%euler, self%pace_between*(load*self%euler - self%euler_between)))
      end function rate

   end subroutine observe_buckling

   !> Whether it is worth a warning.
   pure logical function buckles_unseen(self)
      type(buckling_type), intent(in) :: self
      buckles_unseen = self%worst > beyond .and. self%growth > much
   end function buckles_unseen

   !> Joins what an analysis has seen to that of those before.
   pure subroutine join_buckling(part, whole)
      type(buckling_type), intent(in) :: part
      type(buckling_type), intent(inout) :: whole
      if (.not. buckles_unseen(part) .or. part%worst <= whole%worst) return
      whole = part
   end subroutine join_buckling

   !> Saves or restores it.
   subroutine exchange_buckling(self, snapshot)
      class(buckling_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('buckling_last', self%last)
      call snapshot%exchange('buckling_last_time', self%last_time)
      call snapshot%exchange('buckling_worst', self%worst)
      call snapshot%exchange('buckling_when', self%when)
      call snapshot%exchange('buckling_growth', self%growth)
      ! Not saved: euler, euler_between, pace, pace_between
   end subroutine exchange_buckling

end module limber_monitor_function_buckling
