!> Springs that pass through zero length and come back within a step. There the force of a spring with a free length turns round,
!> which a step does not see if it ends on the side where it began. Floor: analysis. Source: doc/theory, section 5.17.
module limber_analysis_turned_springs
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_multibody_motion_laws, only: name_of_load
   use limber_multibody_point_motion, only: point_position, point_velocity
   use limber_multibody_springs, only: point_spring_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: turned_springs_type, start_springs, note_springs, springs_warning

   !> What is remembered
   type :: turned_springs_type
      !> Loads that are such springs
      integer, allocatable :: loads(:)
      !> Gap of each at the start of the step, and its rate (2, springs), and when that was
      real(wp), allocatable :: gap(:, :), rate(:, :)
      real(wp) :: t = 0.0_wp
      !> The first that turned within a step, 0: none; when, and the length of the step
      integer :: turned = 0
      real(wp) :: time = 0.0_wp, step = 0.0_wp
   contains
      procedure :: exchange => exchange_springs
   end type turned_springs_type

contains

   !> Begins at a state.
   subroutine start_springs(self, system, t, q, v)
      type(turned_springs_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      integer :: i
      self%loads = pack([(i, i=1, size(system%loads))], [(turns_round(system, i), i=1, size(system%loads))])
      allocate (self%gap(2, size(self%loads)), self%rate(2, size(self%loads)))
      if (size(self%loads) > 0) call read_gaps(self, system, t, q, v)
   end subroutine start_springs

   !> Whether a load is a spring whose force at zero length is not zero.
   pure logical function turns_round(system, load)
      type(system_type), intent(in) :: system
      integer, intent(in) :: load
      turns_round = .false.
      select type (item => system%loads(load)%item)
      type is (point_spring_type)
         turns_round = item%stiffness*item%free_length > 0.0_wp
      end select
   end function turns_round

   !> Reads the gaps at a state.
   subroutine read_gaps(self, system, t, q, v)
      type(turned_springs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t, q(:), v(:)
      integer :: k
      self%t = t
      do k = 1, size(self%loads)
         select type (item => system%loads(self%loads(k))%item)
         type is (point_spring_type)
            associate (model => system%model, layout => system%layout, a => system%model%points(item%points(1)), &
               & b => system%model%points(item%points(2)))
               self%gap(:, k) = point_position(model, layout, b, q) - point_position(model, layout, a, q)
               self%rate(:, k) = point_velocity(model, layout, b, q, v) - point_velocity(model, layout, a, q, v)
            end associate
         end select
      end do
   end subroutine read_gaps

   !> Takes a step up to a state.
   subroutine note_springs(self, system, t, q, v)
      type(turned_springs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Time of the state; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      real(wp) :: gap(2, size(self%loads)), rate(2, size(self%loads)), before
      integer :: k
      gap = self%gap
      rate = self%rate
      before = self%t
      call read_gaps(self, system, t, q, v)
      if (self%turned > 0) return
      do k = 1, size(self%loads)
         if (.not. comes_back(t - before, gap(:, k), rate(:, k), self%gap(:, k), self%rate(:, k))) cycle
         self%turned = self%loads(k)
         self%time = t
         self%step = t - before
      end do
   end subroutine note_springs

   !> Whether a cubic vector turns by more than a right angle between two ends that point the same way.
   pure logical function comes_back(h, from, from_rate, to, to_rate)
      !> Time between; the vector and its rate at both ends (2)
      real(wp), intent(in) :: h, from(2), from_rate(2), to(2), to_rate(2)
      integer, parameter :: parts = 16
      real(wp) :: s, between(2)
      integer :: i
      comes_back = .false.
      if (dot_product(from, to) <= 0.0_wp) return
      if (min(norm2(from), norm2(to)) >= h*max(norm2(from_rate), norm2(to_rate))) return
      do i = 1, parts - 1
         s = real(i, wp)/parts
         between = (1 + 2*s)*(1 - s)**2*from + s**2*(3 - 2*s)*to + h*s*(1 - s)*((1 - s)*from_rate - s*to_rate)
         comes_back = comes_back .or. dot_product(between, from) < 0.0_wp
      end do
   end function comes_back

   !> A warning of a spring that has turned within a step; empty if none has.
   function springs_warning(self, system) result(text)
      type(turned_springs_type), intent(in) :: self
      type(system_type), intent(in) :: system
      character(:), allocatable :: text
      text = ''
      if (self%turned == 0) return
      text = 'spring '//name_of_load(system, self%turned)
      text = text//' passes through zero length and comes back within a step, at t = '// &
         & as_text(self%time, 6)//': its force turns round there, which the step does not see, and the motion behind is not'// &
         & ' known; use INTEGRATOR=CONSERVING, or a MAXIMUM STEP far below '//as_text(self%step, 2)//' '// &
         & system%model%units%time
   end function springs_warning

   !> Saves or restores its memory.
   subroutine exchange_springs(self, snapshot)
      class(turned_springs_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('springs_gap', self%gap)
      call snapshot%exchange('springs_rate', self%rate)
      call snapshot%exchange('springs_t', self%t)
      call snapshot%exchange('springs_turned', self%turned)
      call snapshot%exchange('springs_time', self%time)
      call snapshot%exchange('springs_step', self%step)
      ! Not saved: loads
   end subroutine exchange_springs

end module limber_analysis_turned_springs
