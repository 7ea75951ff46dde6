!> Views by chance in which a scene is run, and its deck in a view.
module plans
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use chances, only: pick, between, likely, sow
   use drafts, only: draft_type
   use views, only: view_type, rendered, asked
   implicit none
   private
   public :: plan_type, make_plan, make_target_plan, deck_of, small_change, large_change, number_of_integrator

   character(10), parameter :: integrators(5) = [character(10) :: 'ADAMS', 'RADAU', 'AUTO', 'ALPHA', 'CONSERVING']
   !> Relative change of the scene that tells how it answers, and the one beyond which a warning is of no threshold
   real(wp), parameter :: small_change = 1.0e-4_wp, large_change = 0.1_wp

   !> Views of a scene: the base, the reference at a tighter tolerance, the same of a scene that is changed a little, others
   type :: plan_type
      type(view_type) :: base, reference, changed
      type(view_type), allocatable :: others(:)
   end type plan_type

contains

   !> Views for a scene, by chance, from the number of the scene.
   subroutine make_plan(seed, draft, plan)
      integer, intent(in) :: seed
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(out) :: plan
      integer :: first, second, i, n
      type(view_type) :: view
      call sow(seed + 1000003)
      first = pick(5)
      second = 1 + mod(first + pick(2) - 1, 2)
      if (first <= 2) second = 3 - first
      plan%base%integrator = integrators(first)
      plan%base%tolerance = 10.0_wp**(-(5 + pick(3)))
      if (first >= 4) plan%base%tolerance = 10.0_wp**(-(3 + pick(2)))
      plan%reference = plan%base
      plan%reference%name = 'reference'
      plan%reference%integrator = integrators(second)
      plan%reference%tolerance = max(1.0e-10_wp, min(1.0e-8_wp, plan%base%tolerance/100))
      plan%changed = plan%reference
      plan%changed%name = 'changed'
      plan%changed%change = small_change
      allocate (plan%others(0))
      n = 0
      do while (n < 3)
         view = plan%base
         i = pick(9)
         call set_view(i, draft, view)
         if (view%name == 'base') cycle
         if (any(plan%others%name == view%name)) cycle
         plan%others = [plan%others, view]
         n = n + 1
      end do
   end subroutine make_plan

   !> Views for a scene whose functions, integrator and tolerance limber is to choose: two references, with other functions and
   !> tolerances.
   subroutine make_target_plan(plan)
      type(plan_type), intent(out) :: plan
      plan%base%target = 1.0e-2_wp
      plan%reference%name = 'reference'
      plan%reference%integrator = 'RADAU'
      plan%reference%tolerance = 1.0e-6_wp
      plan%reference%functions = [12, 3]
      plan%changed = plan%reference
      plan%changed%name = 'changed'
      plan%changed%tolerance = 1.0e-7_wp
      plan%changed%functions = [10, 2]
      allocate (plan%others(0))
   end subroutine make_target_plan

   !> One of the views; `base` if it is none for this scene.
   subroutine set_view(number, draft, view)
      integer, intent(in) :: number
      type(draft_type), intent(in) :: draft
      type(view_type), intent(inout) :: view
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp), parameter :: systems(3, 4) = reshape([1.0e-3_wp, 1.0e3_wp, 1.0_wp, 1.0e3_wp, 1.0e3_wp, 1.0e3_wp, &
         & 1.0_wp, 3.28084_wp, 1.0_wp, 10.0_wp, 0.01_wp, 1.0_wp], [3, 4])
      select case (number)
      case (1)
         view%name = 'whole'
         view%eliminated = .false.
      case (2)
         view%name = 'mirror'
         view%side = -1.0_wp
         view%turn = pi
         view%cosine = -1.0_wp
      case (3)
         view%name = 'turn'
         view%turn = between(-3.0_wp, 3.0_wp)
         view%cosine = cos(view%turn)
         view%sine = sin(view%turn)
         if (draft%by_quarters .or. likely(4)) then
            view%turn = pi/2
            view%cosine = 0.0_wp
            view%sine = 1.0_wp
         end if
      case (4)
         view%name = 'move'
         view%moved = [between(-3.0_wp, 3.0_wp), between(-3.0_wp, 3.0_wp)]
         if (likely(4)) view%moved = 100*view%moved
      case (5)
         view%name = 'units'
         view%units = systems(:, pick(size(systems, 2)))
      case (6)
         view%name = 'names'
         view%renamed = .true.
      case (7)
         if (draft%timeless) return
         view%name = 'later'
         view%start = merge(100.0_wp, 3.0_wp, likely(2))
      case (8)
         view%name = 'exchange'
         view%exchanged = .true.
      case (9)
         view%name = 'order'
         view%order = pick(1000)
         view%renamed = likely(2)
      end select
   end subroutine set_view

   !> The deck of a scene in a view.
   function deck_of(draft, view) result(text)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      character(:), allocatable :: text
      type(view_type) :: now
      integer, allocatable :: order(:)
      integer :: i, k, part, swap
      now = view
      order = [(i, i=1, size(draft%blocks))]
      if (view%order > 0) then
         call sow(view%order)
         do i = size(order), 2, -1
            k = pick(i)
            swap = order(i)
            if (draft%blocks(order(i))%part /= 2 .or. draft%blocks(order(k))%part /= 2) cycle
            order(i) = order(k)
            order(k) = swap
         end do
      end if
      text = ''
      do part = 1, 3
         do i = 1, size(order)
            if (draft%blocks(order(i))%part == part) text = text//rendered(draft%blocks(order(i))%text, now)
         end do
      end do
      text = text//'*OUTPUT'
      if (draft%envelope /= '') text = text//rendered(', ENVELOPE=<N|'//trim(draft%envelope)//'>', now)
      text = text//newline
      do i = 1, size(draft%channels)
         text = text//asked(draft%channels(i), now)
      end do
   end function deck_of

   pure integer function number_of_integrator(integrator) result(number)
      character(*), intent(in) :: integrator
      do number = 1, size(integrators) - 1
         if (integrators(number) == integrator) return
      end do
   end function number_of_integrator

end module plans
