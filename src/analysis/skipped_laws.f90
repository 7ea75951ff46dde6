!> Laws between two equilibria. Their bounds are halved along the straight way from one to the other. Floor: analysis. Source:
!> doc/theory, eqs. (5.43), (5.53).
module limber_analysis_skipped_laws
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_motion_laws, only: moment_type, new_moment, read_moment, watched_loads, law_excess, law_noise, law_within
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: skips_law, bent_law

   !> A law along the way
   type :: way_type
      !> Slots at both ends (slots)
      real(wp), allocatable :: from(:), to(:)
      !> Values at both ends, and rates along the way
      type(jet_type) :: first, last
      !> What is round-off of its values at equilibrium, where it may cancel with all else
      real(wp) :: noise = 0.0_wp
      !> Looks that are left
      integer :: looks = 0
   end type way_type

contains

   !> Whether a law is something between two states that its values and slopes there do not show. Kinematics are left at the second.
   logical function skips_law(system, work, before, after, from, to, culprit) result(skips)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Times of both states; coordinates (nq)
      real(wp), intent(in) :: before, after, from(:), to(:)
      !> Index of its load; unchanged if there is none
      integer, intent(inout) :: culprit
      integer, parameter :: most_looks = 500
      !> Known places, relative to the scales times 1000
      real(wp), parameter :: known = 1.0e-5_wp
      type(moment_type) :: ends(2)
      type(way_type) :: way
      real(wp) :: rest(size(from))
      integer :: i
      skips = .false.
      associate (loads => watched_loads(system))
         if (size(loads) == 0) return
         rest = 0.0_wp
         call new_moment(size(loads), ends(1))
         call new_moment(size(loads), ends(2))
         call place_frames(system%model, system%layout, before, from, work%kinematics)
         call move_frames(system%model, system%layout, from, rest, work%kinematics)
         call read_moment(system, loads, work%kinematics, ends(1))
         call place_frames(system%model, system%layout, after, to, work%kinematics)
         call move_frames(system%model, system%layout, to, rest, work%kinematics)
         call read_moment(system, loads, work%kinematics, ends(2))
         do i = 1, size(loads)
            select type (load => system%loads(loads(i))%item)
            type is (force_element_type)
               way%from = merge(0.0_wp, ends(1)%place(:size(load%slots), i), load%by_rate(:size(load%slots)))
               way%to = merge(0.0_wp, ends(2)%place(:size(load%slots), i), load%by_rate(:size(load%slots)))
               way%first = value_at(load, way, 0.0_wp)
               way%last = value_at(load, way, 1.0_wp)
               way%looks = most_looks
               if (.not. abs(load%factor) > 0.0_wp) cycle
               way%noise = max(law_noise(system, loads, i, ends(1), known, 1.0_wp, 1.0_wp), &
                  & law_noise(system, loads, i, ends(2), known, 1.0_wp, 1.0_wp))/abs(load%factor)
               call search(load, way, 0.0_wp, 1.0_wp, way%first%value, way%last%value, skips)
            end select
            if (.not. skips) cycle
            culprit = loads(i)
            return
         end do
      end associate
   end function skips_law

   !> The first load whose law bends or jumps right beside a state; 0: none.
   integer function bent_law(system, work, t, q) result(culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time, coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      !> What is beside it, relative to values, the length of the scene or a radian
      real(wp), parameter :: beside = 1.0e-4_wp
      type(moment_type) :: here
      type(range_type) :: range
      real(wp) :: rest(size(q))
      real(wp), allocatable :: aside(:)
      integer :: i
      culprit = 0
      associate (loads => watched_loads(system))
         rest = 0.0_wp
         call new_moment(size(loads), here)
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, rest, work%kinematics)
         call read_moment(system, loads, work%kinematics, here)
         do i = 1, size(loads)
            select type (load => system%loads(loads(i))%item)
            type is (force_element_type)
               associate (place => here%place(:size(load%slots), i))
                  aside = beside*(abs(place) + max(1.0_wp, system%model%length))
                  range = law_within(load, place - aside, place + aside)
                  if (.not. range%whole .and. culprit == 0) culprit = loads(i)
               end associate
            end select
         end do
      end associate
   end function bent_law

   !> The law at a part of the way, with its rate along it.
   pure type(jet_type) function value_at(load, way, s) result(jet)
      type(force_element_type), intent(in) :: load
      type(way_type), intent(in) :: way
      real(wp), intent(in) :: s
      integer :: k
      jet = load%law%evaluate_along([(jet_type(way%from(k) + s*(way%to(k) - way%from(k)), way%to(k) - way%from(k), 0.0_wp), &
         & k=1, size(way%from))])
   end function value_at

   !> Halves a part of the way until bounds tell that nothing is in it, or a value is found that is not that of the cubic through
   !> both ends, eq. (5.53).
   recursive subroutine search(load, way, a, b, of_a, of_b, skips)
      type(force_element_type), intent(in) :: load
      type(way_type), intent(inout) :: way
      !> Ends of the part, values there
      real(wp), intent(in) :: a, b, of_a, of_b
      logical, intent(inout) :: skips
      !> Parts of the largest value: bounds beyond both ends, distance from the cubic; shortest part of the way
      real(wp), parameter :: little = 1.0e-3_wp, tolerance = 0.1_wp, shortest = 1.0e-9_wp
      type(range_type) :: range
      type(jet_type) :: middle
      real(wp) :: s, largest, cubic
      range = law_within(load, way%from + a*(way%to - way%from), way%from + b*(way%to - way%from))
      largest = max(abs(way%first%value), abs(way%last%value))
      if (range%defined) largest = max(largest, abs(range%low), abs(range%high))
      if (law_excess(range, of_a, of_b) <= little*largest + way%noise .or. way%looks == 0 .or. b - a < shortest) return
      s = 0.5_wp*(a + b)
      middle = value_at(load, way, s)
      way%looks = way%looks - 1
      cubic = (1 - s)**2*((1 + 2*s)*way%first%value + s*way%first%first) + s**2*((3 - 2*s)*way%last%value - &
         & (1 - s)*way%last%first)
      largest = max(abs(way%first%value), abs(way%last%value), abs(middle%value))
      skips = abs(middle%value - cubic) > tolerance*largest + way%noise
      if (.not. skips) call search(load, way, a, s, of_a, middle%value, skips)
      if (.not. skips) call search(load, way, s, b, middle%value, of_b, skips)
   end subroutine search

end module limber_analysis_skipped_laws
