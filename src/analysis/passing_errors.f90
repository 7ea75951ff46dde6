!> Errors of many passages of laws of the motion. Each is below the tolerance, but where all are of one sign they add up. Between
!> some of the crossings the errors of the steps are found, and from these the sum over all. Floor: analysis. Source: doc/theory,
!> eqs. (5.68), (5.69).
module limber_analysis_passing_errors
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_analysis_crossings, only: crossings_type
   use limber_analysis_step_defects, only: defect_type
   use limber_model_model, only: dynamics_type
   use limber_multibody_layout, only: rates_of
   use limber_multibody_motion_laws, only: describe_law
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: passages_type, start_passages, note_rates, looks_at, note_passage, count_passage, passing_warning

   !> Of so many intervals between crossings one is looked at, first and later; odd numbers see what laws do and what lies between
   integer, parameter :: closely = 3, later = 9
   !> Crossings from which on a law comes and goes often, and from which on fewer are looked at
   integer, parameter :: often = 40, many = 300

   !> What is known of the passages
   type :: passages_type
      !> Crossings so far, in all and of each law (laws)
      integer :: crossings = 0
      integer, allocatable :: of(:)
      !> Largest magnitude of each rate (nw)
      real(wp), allocatable :: largest(:)
      !> Errors of each rate in the interval at hand, and along its sign; sums of both over all, and of their squares (nw)
      real(wp), allocatable :: now(:), with(:), sum(:), sum_with(:), square(:), square_with(:)
      !> Scratch (nw)
      real(wp), allocatable, private :: w(:)
   contains
      procedure :: exchange => exchange_passages
   end type passages_type

contains

   !> Begins.
   subroutine start_passages(self, system, laws)
      type(passages_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Number of watched laws
      integer, intent(in) :: laws
      allocate (self%of(laws), source=0)
      associate (nw => system%layout%nw)
         allocate (self%largest(nw), self%now(nw), self%with(nw), self%sum(nw), self%sum_with(nw), self%square(nw), &
            & self%square_with(nw), self%w(nw), source=0.0_wp)
      end associate
   end subroutine start_passages

   !> Takes the rates at the end of a step.
   pure subroutine note_rates(self, system, q, v)
      type(passages_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      call rates_of(system%layout, q, v, self%w)
      self%largest = max(self%largest, abs(self%w))
   end subroutine note_rates

   !> Whether the last step is in an interval that is looked at, and a law does something in it.
   pure logical function looks_at(self, crossings) result(looks)
      type(passages_type), intent(in) :: self
      type(crossings_type), intent(in) :: crossings
      looks = .false.
      if (self%crossings == 0) return
      looks = mod(self%crossings, stride(self)) == 0 .and. .not. all(crossings%idle)
   end function looks_at

   !> Takes the errors of a step.
   pure subroutine note_passage(self, defect)
      type(passages_type), intent(inout) :: self
      type(defect_type), intent(in) :: defect
      self%now = self%now + defect%rates
      self%with = self%with + sign(1.0_wp, defect%w)*defect%rates
   end subroutine note_passage

   !> Counts a crossing that has been met: an interval ends there.
   pure subroutine count_passage(self, crossings)
      type(passages_type), intent(inout) :: self
      type(crossings_type), intent(in) :: crossings
      self%now = self%now*stride(self)
      self%with = self%with*stride(self)
      self%sum = self%sum + self%now
      self%square = self%square + self%now**2
      self%sum_with = self%sum_with + self%with
      self%square_with = self%square_with + self%with**2
      self%now = 0.0_wp
      self%with = 0.0_wp
      self%crossings = self%crossings + 1
      self%of(crossings%which) = self%of(crossings%which) + 1
   end subroutine count_passage

   !> Of so many intervals one is looked at.
   pure integer function stride(self)
      type(passages_type), intent(in) :: self
      stride = merge(closely, later, self%crossings < many)
   end function stride

   !> A warning if the errors of many passages have added up in the speed of a body, eq. (5.69).
   function passing_warning(self, system, crossings, dynamics) result(text)
      type(passages_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(crossings_type), intent(in) :: crossings
      type(dynamics_type), intent(in) :: dynamics
      !> Empty if all is well
      character(:), allocatable :: text
      !> Part of the largest speed that may be off, and part of the tolerance below which a speed is nothing
      real(wp), parameter :: allowed = 2.0e-2_wp, nothing = 1.0e-2_wp
      real(wp) :: share, most, fastest
      character(*), parameter :: directions(3) = [character(20) :: 'the speed along x', 'the speed along y', 'the angular velocity']
      integer :: i, k, at, body, worst
      text = ''
      if (self%crossings < often) return
      most = allowed
      worst = 0
      body = 0
      fastest = maxval([(maxval(self%largest(system%layout%w(i):system%layout%w(i) + 1)), i=1, size(system%layout%w))], &
         & mask=.not. system%layout%carries)
      do i = 1, size(system%layout%w)
         if (system%layout%carries(i)) cycle
         do k = 1, merge(3, 2, system%layout%framed(i))
            at = system%layout%w(i) + k - 1
            if (.not. self%largest(at)*merge(system%model%length, 1.0_wp, k == 3) > nothing*dynamics%tolerance*fastest) cycle
            share = max(added(self%sum(at), self%square(at), self%largest(at)), &
               & added(self%sum_with(at), self%square_with(at), self%largest(at)))
            if (share <= most) cycle
            most = share
            worst = k
            body = i
         end do
      end do
      if (body == 0) return
      text = describe_law(system, crossings%loads(maxloc(self%of, dim=1)))//' comes and goes '//as_text(self%crossings/2)// &
         & ' times, and the errors of these passages add up: '//trim(directions(worst))//" of body '"// &
         & system%model%bodies(body)%name//"' may be off by about "//as_text(100*min(most, 1.0_wp), 2)// &
         & ' % of its largest value'//trim(merge(' or more', '        ', most > 1.0_wp))//'; use '//dynamics%finer()// &
         & trim(merge('                    ', ' or INTEGRATOR=RADAU', dynamics%integrator == 'RADAU'))
   end function passing_warning

   !> What errors add up to relative to the largest value, eq. (5.69): their sum if they are of one sign; if they are of both, and
   !> not little, at least what such leave.
   pure real(wp) function added(sum, square, largest) result(share)
      !> Sums of the errors and of their squares, largest value
      real(wp), intent(in) :: sum, square, largest
      !> Sum in units of what errors of both signs leave, part of the largest value that is little
      real(wp), parameter :: of_one_sign = 2.0_wp, little = 3.0e-2_wp
      share = abs(sum)/largest
      if (abs(sum) > of_one_sign*sqrt(square)) return
      share = max(abs(sum), sqrt(square))/largest
      if (sqrt(square) <= little*largest) share = 0.0_wp
   end function added

   !> Saves or restores its memory.
   subroutine exchange_passages(self, snapshot)
      class(passages_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      if (.not. allocated(self%of)) return
      call snapshot%exchange('passages', self%crossings)
      do i = 1, size(self%of)
         call snapshot%exchange('passages_of', self%of(i))
      end do
      call snapshot%keep('passages_largest', self%largest)
      call snapshot%keep('passages_now', self%now)
      call snapshot%keep('passages_with', self%with)
      call snapshot%keep('passages_sum', self%sum)
      call snapshot%keep('passages_sum_with', self%sum_with)
      call snapshot%keep('passages_square', self%square)
      call snapshot%keep('passages_square_with', self%square_with)
      ! Not saved: w
   end subroutine exchange_passages

end module limber_analysis_passing_errors
