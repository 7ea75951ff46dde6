!> Curves of several formulas in a motion. Only the piece on which a point is counts, and goes on smoothly beyond its ends, so that
!> steps do not see what comes behind. Where the point reaches an end the step is cut, and the next piece counts. A kink is an
!> impact: what of the velocity is across the new direction is lost. A jump is an error, and so is a kink that the point cannot
!> leave. Floor: analysis. Source: doc/theory, eqs. (5.58)-(5.60).
module limber_analysis_curve_pieces
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_scene_outcome, only: outcome_type, warn
   use limber_integrator_integrator, only: integrator_type
   use limber_model_curve, only: limit_curve, release_curve
   use limber_model_curve_breaks, only: curve_break_type, find_curve_breaks, break_jump, break_kink
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_path_constraints, only: curve_joint_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: curve_pieces_type, new_pieces, begin_pieces, look_ahead, find_end, pass_end, &
      & count_kink, tell_kinks, release_pieces

   !> Distance from an end of a piece that is none, relative to the length of the scene; the same for steps that end there
   real(wp), parameter :: none = 1.0e-10_wp, near = 1.0e-9_wp
   !> Passages of one end, to and fro, that count as rest, and the part of the time before in which each comes
   integer, parameter :: most_returns = 12
   real(wp), parameter :: tight = 0.01_wp

   !> One curve
   type :: path_type
      !> Index of its constraint
      integer :: joint = 0
      !> Changes of the formula in what has been searched, and between which the point is: behind this one; and ends of that
      type(curve_break_type), allocatable :: breaks(:)
      integer :: piece = 0
      real(wp) :: searched(2) = 0.0_wp
      !> Kinks passed, the first of them and its time, what the energy has changed by there
      integer :: kinks = 0
      real(wp) :: first = 0.0_wp, first_time = 0.0_wp, energy = 0.0_wp
      !> The last end that was passed, when, the time before that which counts as long, and how often it was soon again
      real(wp) :: last = 0.0_wp, last_time = 0.0_wp, long = 0.0_wp
      integer :: returns = 0
   end type path_type

   !> All curves that may be of several formulas
   type :: curve_pieces_type
      type(path_type), allocatable :: paths(:)
      !> Where a step must be cut: time, which curve, and whether the point leaves its piece upwards
      real(wp) :: t = huge(1.0_wp)
      integer :: which = 0
      logical :: upwards = .false.
      !> Length of the scene, and of the analysis
      real(wp) :: length = 0.0_wp, duration = 0.0_wp
      real(wp), allocatable :: q(:), v(:)
   contains
      procedure :: exchange => exchange_pieces
   end type curve_pieces_type

contains

   !> Which curves these are.
   subroutine new_pieces(self, system, start, duration)
      type(curve_pieces_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> First time, and length of the analysis
      real(wp), intent(in) :: start, duration
      type(path_type) :: path
      integer :: i
      allocate (self%paths(0))
      self%length = system%model%length
      self%duration = duration
      allocate (self%q(system%layout%nq), self%v(system%layout%nq), source=0.0_wp)
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (curve_joint_type)
            if (item%part_of > 0 .or. .not. item%curve%explicit) cycle
            if (.not. item%curve%expression%may_bend()) cycle
            path = path_type(joint=i, last_time=start)
            allocate (path%breaks(0))
            self%paths = [self%paths, path]
         end select
      end do
   end subroutine new_pieces

   !> Finds the pieces on which the points are at the start, and lets these count.
   subroutine begin_pieces(self, system, work, t, q, v)
      type(curve_pieces_type), intent(inout) :: self
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      real(wp) :: x, rate
      integer :: i
      do i = 1, size(self%paths)
         associate (path => self%paths(i))
            call read_place(path, system, work, t, q, v, x, rate)
            path%searched = x + [-1, 1]*self%length
            call search(path, system, path%searched(1), path%searched(2), path%breaks)
            ! At a change of formula, the piece that it moves into
            path%piece = count(path%breaks%place <= x + merge(-1, 1, rate < 0.0_wp)*none*self%length)
            call use_piece(path, system)
         end associate
      end do
   end subroutine begin_pieces

   !> Searches on where points come near to what is not known. Whether a step has passed what was not known: then it must be done
   !> again.
   logical function look_ahead(self, system, work, t, q, v) result(again)
      type(curve_pieces_type), intent(inout) :: self
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> State at the end of the step
      real(wp), intent(in) :: t, q(:), v(:)
      type(curve_break_type), allocatable :: more(:)
      real(wp) :: x, rate, edge, low, high
      integer :: i
      again = .false.
      do i = 1, size(self%paths)
         associate (path => self%paths(i))
            call read_place(path, system, work, t, q, v, x, rate)
            if (x > path%searched(2) - 0.5_wp*self%length) then
               edge = path%searched(2)
               path%searched(2) = x + self%length
               call search(path, system, edge - none*self%length, path%searched(2), more)
               if (size(path%breaks) > 0) more = pack(more, more%place > path%breaks(size(path%breaks))%behind)
               path%breaks = [path%breaks, more]
            else if (x < path%searched(1) + 0.5_wp*self%length) then
               edge = path%searched(1)
               path%searched(1) = x - self%length
               call search(path, system, path%searched(1), edge + none*self%length, more)
               if (size(path%breaks) > 0) more = pack(more, more%place < path%breaks(1)%before)
               path%piece = path%piece + size(more)
               path%breaks = [more, path%breaks]
            else
               cycle
            end if
            if (size(more) == 0) cycle
            call use_piece(path, system)
            call ends_of(path, low, high)
            again = again .or. x < low .or. x > high
         end associate
      end do
   end function look_ahead

   !> When within the last step the first point reaches the end of its piece: `t`, `which`; huge if none does.
   subroutine find_end(self, system, work, integrator)
      type(curve_pieces_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      integer, parameter :: looks = 4, rounds = 60
      real(wp) :: x, low, high, left, right, middle, edge, last
      integer :: i, k, round
      self%t = huge(self%t)
      do i = 1, size(self%paths)
         associate (path => self%paths(i), h => integrator%t - integrator%t_before)
            call ends_of(path, low, high)
            if (low <= -huge(low) .and. high >= huge(high)) cycle
            left = integrator%t_before
            do k = 1, looks
               right = integrator%t_before + h*k/looks
               if (k == looks) right = integrator%t
               x = place_at(right)
               if (x > high + none*self%length .or. x < low - none*self%length) exit
               left = right
            end do
            if (k > looks) then
               if (integrator%ends_on_samples) call meet_end()
               cycle
            end if
            edge = merge(high, low, x > high)
            do round = 1, rounds
               middle = left + 0.5_wp*(right - left)
               if (middle <= left .or. middle >= right) exit
               if ((place_at(middle) - edge)*merge(1, -1, x > high) > 0.0_wp) then
                  right = middle
               else
                  left = middle
               end if
            end do
            if (right >= self%t) cycle
            self%t = right
            self%which = i
            self%upwards = x > high
            last = place_at(integrator%t)
            if (integrator%ends_on_samples .and. abs(last - edge) <= near*self%length) self%t = integrator%t
         end associate
      end do

   contains

      !> Where the point is within the step.
      real(wp) function place_at(t) result(place)
         real(wp), intent(in) :: t
         real(wp) :: w
         call integrator%interpolate(t, self%q, self%v, w)
         call integrator%complete(system, work, t, self%q, self%v)
         call read_place(self%paths(i), system, work, t, self%q, self%v, place)
      end function place_at

      !> A step that ends right before the end counts as one that reaches it.
      subroutine meet_end()
         real(wp) :: from
         if (min(abs(x - low), abs(x - high)) > near*self%length) return
         from = place_at(integrator%t_before)
         if (abs(x - from) <= near*self%length .or. integrator%t >= self%t) return
         if ((x > from) .neqv. (abs(x - high) < abs(x - low))) return
         self%t = integrator%t
         self%which = i
         self%upwards = x > from
      end subroutine meet_end

   end subroutine find_end

   !> Lets the next piece count of the curve whose end was found. An error if it jumps there.
   subroutine pass_end(self, system, t, error)
      type(curve_pieces_type), intent(inout) :: self
      type(system_type), intent(inout) :: system
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      type(curve_break_type) :: there
      associate (path => self%paths(self%which))
         there = path%breaks(merge(path%piece + 1, path%piece, self%upwards))
         if (there%kind == break_jump) then
            call raise(error, system%constraints(path%joint)%item%label//': its curve jumps at x = '//as_text(there%place, 6)// &
               & ', from y = '//as_text(there%left%value, 6)//' to '//as_text(there%right%value, 6)//', where its point arrives'// &
               & ' at t = '//as_text(t, 8)//'; a point cannot follow: use smoothstep((x - x0)/width) in place of a jump')
            return
         end if
         path%piece = path%piece + merge(1, -1, self%upwards)
         call use_piece(path, system)
      end associate
   end subroutine pass_end

   !> Counts the kink that was passed. An error if the point cannot leave it, or is there again and again: it rests in it.
   subroutine count_kink(self, system, work, t, q, v, energy, error)
      type(curve_pieces_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> State behind it
      real(wp), intent(in) :: t, q(:), v(:)
      !> What the energy has changed by
      real(wp), intent(in) :: energy
      type(error_type), allocatable, intent(out) :: error
      !> Way between two passages, in parts of the scene, that is round-off
      real(wp), parameter :: still = 1.0e-9_wp
      type(curve_break_type) :: there
      real(wp) :: since, x, rate, turn
      associate (path => self%paths(self%which))
         there = path%breaks(merge(path%piece, path%piece + 1, self%upwards))
         call read_place(path, system, work, t, q, v, x, rate)
         since = t - path%last_time
         if (abs(there%place - path%last) <= none*self%length .and. (since < tight*path%long &
            & .or. abs(rate)*since < still*self%length)) then
            path%returns = path%returns + 1
         else
            path%returns = 0
            path%long = max(since, 1.0e-3_wp*self%duration)
         end if
         path%last = there%place
         path%last_time = t
         if (there%kind /= break_kink) return
         turn = abs(atan(there%right%first) - atan(there%left%first))
         if (turn >= 0.5_wp*acos(-1.0_wp) - 1.0e-3_wp .or. path%returns >= most_returns) then
            call raise(error, system%constraints(path%joint)%item%label//': its point is stopped at t = '//as_text(t, 8)// &
               & ' by a kink of its curve, at x = '//as_text(there%place, 6)//', which turns by '// &
               & as_text(turn*180/acos(-1.0_wp), 3)//' degrees: in the kink it has no direction to go; round the kink, by a'// &
               & ' *CURVE through points or smoothstep')
            return
         end if
         path%kinks = path%kinks + 1
         path%energy = path%energy + energy
         if (path%kinks > 1) return
         path%first = there%place
         path%first_time = t
      end associate
   end subroutine count_kink

   !> A warning for each curve with kinks that were passed.
   subroutine tell_kinks(self, system, outcome)
      type(curve_pieces_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(outcome_type), intent(inout) :: outcome
      character(:), allocatable :: many
      integer :: i
      do i = 1, size(self%paths)
         associate (path => self%paths(i))
            if (path%kinks == 0) cycle
            many = 'a kink of its curve, at x = '
            if (path%kinks > 1) many = 'kinks of its curve '//as_text(path%kinks)//' times, the first at x = '
            call warn(outcome, system%constraints(path%joint)%item%label//': its point passes '//many//as_text(path%first, 6)// &
               & ', t = '//as_text(path%first_time, 8)//': velocities jump there as by an impact, and the energy changes by '// &
               & as_text(path%energy, 3)//trim(merge(' in all', '       ', path%kinks > 1))//'; if the curve is to have none,'// &
               & ' round it by a *CURVE through points or smoothstep')
         end associate
      end do
   end subroutine tell_kinks

   !> Lets all of each curve count again.
   subroutine release_pieces(system)
      type(system_type), intent(inout) :: system
      integer :: i
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (curve_joint_type)
            call release_curve(item%curve)
         end select
      end do
   end subroutine release_pieces

   !> Where the point of a curve is at a state, and how it moves.
   subroutine read_place(path, system, work, t, q, v, place, rate)
      type(path_type), intent(in) :: path
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      !> x, and its rate
      real(wp), intent(out) :: place
      real(wp), intent(out), optional :: rate
      real(wp) :: here(2), moves(2)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      if (present(rate)) call move_frames(system%model, system%layout, q, v, work%kinematics)
      place = 0.0_wp
      select type (item => system%constraints(path%joint)%item)
      type is (curve_joint_type)
         if (present(rate)) then
            call item%place(work%kinematics, here, moves)
            rate = moves(1)
         else
            call item%place(work%kinematics, here)
         end if
         place = here(1)
      end select
   end subroutine read_place

   !> The changes of the formula of a curve between two places.
   subroutine search(path, system, from, to, breaks)
      type(path_type), intent(in) :: path
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: from, to
      type(curve_break_type), allocatable, intent(out) :: breaks(:)
      select type (item => system%constraints(path%joint)%item)
      type is (curve_joint_type)
         call find_curve_breaks(item%curve, from, to, breaks)
      end select
   end subroutine search

   !> Places of the ends of the piece on which the point is; huge ones for none.
   pure subroutine ends_of(path, low, high)
      type(path_type), intent(in) :: path
      real(wp), intent(out) :: low, high
      low = -huge(low)
      high = huge(high)
      if (path%piece > 0) low = path%breaks(path%piece)%place
      if (path%piece < size(path%breaks)) high = path%breaks(path%piece + 1)%place
   end subroutine ends_of

   !> Lets the piece count on which the point is.
   subroutine use_piece(path, system)
      type(path_type), intent(in) :: path
      type(system_type), intent(inout) :: system
      real(wp) :: low, high
      low = -huge(low)
      high = huge(high)
      if (path%piece > 0) low = path%breaks(path%piece)%behind
      if (path%piece < size(path%breaks)) high = path%breaks(path%piece + 1)%before
      select type (item => system%constraints(path%joint)%item)
      type is (curve_joint_type)
         call limit_curve(item%curve, low, high)
      end select
   end subroutine use_piece

   !> Saves or restores what is remembered.
   subroutine exchange_pieces(self, snapshot, system)
      class(curve_pieces_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(inout) :: system
      integer :: i
      do i = 1, size(self%paths)
         associate (path => self%paths(i))
            call snapshot%exchange('curve_piece', path%piece)
            call snapshot%exchange('curve_searched_from', path%searched(1))
            call snapshot%exchange('curve_searched_to', path%searched(2))
            call snapshot%exchange('curve_kinks', path%kinks)
            call snapshot%exchange('curve_first', path%first)
            call snapshot%exchange('curve_first_time', path%first_time)
            call snapshot%exchange('curve_energy', path%energy)
            call snapshot%exchange('curve_last', path%last)
            call snapshot%exchange('curve_last_time', path%last_time)
            call snapshot%exchange('curve_long', path%long)
            call snapshot%exchange('curve_returns', path%returns)
            if (.not. snapshot%restoring) cycle
            call search(path, system, path%searched(1), path%searched(2), path%breaks)
            call use_piece(path, system)
         end associate
      end do
      ! Not saved: t, which, upwards, length, duration, q, v
   end subroutine exchange_pieces

end module limber_analysis_curve_pieces
