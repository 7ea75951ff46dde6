!> An impact at gaps that are closed: impulses by the law of Newton, and which contacts rest behind it. A contact rests if what is
!> left of its bounces is below what the search for touches resolves; the time they would take is their geometric sum. Floor:
!> analysis. Source: doc/theory, eqs. (5.86)-(5.90).
module limber_analysis_impact
   use limber_base_kinds, only: wp
   use limber_multibody_complementarity, only: solve_complementarity
   use limber_multibody_contact_impulses, only: gap_set_type, add_impulses, gap_accelerations
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: impact_type, find_impact

   !> Acceleration that counts as none, relative to the terms that it is made of
   real(wp), parameter :: none = 1.0e-10_wp

   !> What happens at gaps (n)
   type :: impact_type
      !> Rates of the gaps right before and right behind; impulses at them
      real(wp), allocatable :: before(:), behind(:), impulse(:)
      !> Forces of the contacts that rest; accelerations of the gaps with these
      real(wp), allocatable :: force(:), acceleration(:)
      !> Whether each contact is closed behind, and how long its bounces would have gone on
      logical, allocatable :: rests(:)
      real(wp), allocatable :: remaining(:)
      !> Changes of rates that are round-off, or the error of what rested before
      real(wp), allocatable :: noise(:)
      !> False if no impulses end the approach: what is met there does not give way
      logical :: solved = .true.
   contains
      procedure :: energies
   end type impact_type

contains

   !> Changes of the kinetic energy by the impulses of the contacts, eq. (5.88) (n).
   pure function energies(self)
      class(impact_type), intent(in) :: self
      real(wp) :: energies(size(self%impulse))
      energies = 0.5_wp*(self%before + self%behind)*self%impulse
   end function energies

   !> Finds the impulses, and changes the velocities by them. `linearise` at the state comes first, with all contacts open.
   subroutine find_impact(system, work, set, q, restitution, height, may_rest, v, impact)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(gap_set_type), intent(in) :: set
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      !> Of each contact; height of bounces below which it rests [length or rad] (n)
      real(wp), intent(in) :: restitution(:), height(:)
      logical, intent(in) :: may_rest(:)
      !> In: right before, out: right behind (nq)
      real(wp), contiguous, intent(inout) :: v(:)
      !> In: rates before are set
      type(impact_type), intent(inout) :: impact
      real(wp) :: first(size(v)), e(size(height)), right(size(height)), free(size(height)), scale(size(height))
      logical :: rest(size(height)), more(size(height))
      integer :: round
      first = v
      e = restitution
      rest = .false.
      allocate (impact%impulse(size(e)), impact%behind(size(e)), impact%force(size(e)), impact%acceleration(size(e)))
      allocate (impact%rests(size(e)), source=.false.)
      allocate (impact%remaining(size(e)), source=0.0_wp)
      do round = 1, size(e) + 1
         right = impact%before + e*min(impact%before, 0.0_wp)
         call solve_complementarity(set%mobility, right, impact%impulse, impact%solved)
         if (.not. impact%solved) return
         impact%behind = impact%before + matmul(set%mobility, impact%impulse)
         v = first
         call add_impulses(system, work, set, impact%impulse, v)
         call gap_accelerations(system, work, set, q, v, free, scale)
         call press(may_rest, impact, set%mobility, free, scale, height, e, rest, more)
         if (.not. impact%solved) return
         if (.not. any(more)) exit
         rest = rest .or. more
         where (rest) e = 0.0_wp
      end do
      impact%rests = rest .and. impact%force > 0.0_wp
   end subroutine find_impact

   !> Forces of contacts that rest, eq. (5.89), and which rest besides, eq. (5.90): those so slow that what is left of their bounces
   !> is low. A contact may be pressed down by another one that rests.
   subroutine press(may_rest, impact, mobility, free, scale, height, e, rest, more)
      logical, intent(in) :: may_rest(:)
      type(impact_type), intent(inout) :: impact
      !> Accelerations of the gaps without forces at them, and what their round-off is relative to (n)
      real(wp), intent(in) :: mobility(:, :), free(:), scale(:), height(:)
      !> Restitution (n)
      real(wp), intent(in) :: e(:)
      !> Which rest as far as is known; which others do
      logical, intent(in) :: rest(:)
      logical, intent(out) :: more(:)
      logical :: grows(size(rest))
      integer :: round
      more = .false.
      do round = 1, size(rest) + 1
         call hold_up(mobility, free, rest .or. more, impact)
         if (.not. impact%solved) return
         grows = may_rest .and. .not. (rest .or. more) .and. impact%acceleration < -none*scale &
            & .and. impact%behind**2 <= -2*impact%acceleration*height
         if (.not. any(grows)) return
         where (grows .and. impact%before < 0.0_wp .and. e > 0.0_wp .and. e < 1.0_wp) &
            & impact%remaining = 2*impact%behind/(-impact%acceleration*(1 - e))
         more = more .or. grows
      end do
   end subroutine press

   !> Forces at some gaps that keep their accelerations from being negative, and those of all gaps then.
   subroutine hold_up(mobility, free, held, impact)
      real(wp), intent(in) :: mobility(:, :), free(:)
      logical, intent(in) :: held(:)
      type(impact_type), intent(inout) :: impact
      integer :: list(count(held)), i
      real(wp) :: force(count(held))
      list = pack([(i, i=1, size(held))], held)
      impact%force = 0.0_wp
      call solve_complementarity(mobility(list, list), free(list), force, impact%solved)
      impact%force(list) = force
      impact%acceleration = free + matmul(mobility, impact%force)
   end subroutine hold_up

end module limber_analysis_impact
