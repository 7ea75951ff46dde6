!> INTEGRATOR=AUTO: the integrator for a scene. What counts is how much faster its fastest vibration or decay is than its motion,
!> what the tolerance asks, and whether the vibration is excited. The numbers come from runs of the slider-crank, the spin-up and
!> the squeezer (doc/benchmarks.md). Floor: scene. Source: doc/theory, eq. (5.61).
module limber_scene_integrator_choice
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: dynamics_type, driver_angle, driver_joint_angle
   use limber_model_beam_segments, only: pieces_of
   use limber_model_switches, only: acts
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_equations_of_motion, only: linearise, accelerations, accelerate
   use limber_multibody_layout, only: rates_of
   use limber_multibody_motion_residual, only: motion_residual, linearise_motion
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, new_tangent
   use limber_multibody_tangent_products, only: times_damping, times_stiffness
   implicit none
   private
   public :: choose_integrator, choice_type, look_at_state, suits_adams

   !> What is known of a scene at a state
   type :: choice_type
      !> Fastest vibration [rad/time], fastest decay [1/time], and fastest motion [rad/time]
      real(wp) :: fastest = 0.0_wp, decay = 0.0_wp, motion = 0.0_wp
      !> Amplitude of the vibrations that the start excites and that are faster than the motion, relative to the deflection's scale
      real(wp) :: ringing = 0.0_wp
   contains
      procedure :: rate, rate_words
   end type choice_type

contains

   !> The integrator for a scene at its first state, and why.
   subroutine choose_integrator(system, work, q, v, integrator, reason)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Assembled coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      character(:), allocatable, intent(out) :: integrator, reason
      type(choice_type) :: found
      call look_at_state(system, work, system%model%dynamics%start, q, v, found)
      call decide(found, system%powered .or. any(system%layout%carries), system%model%dynamics, &
         & system%model%units%time, integrator, reason)
   end subroutine choose_integrator

   !> The fastest rate of the linearised system, which bounds the steps of an explicit method [1/time].
   pure real(wp) function rate(self)
      class(choice_type), intent(in) :: self
      rate = max(self%fastest, self%decay)
   end function rate

   !> What has this rate: 'the fastest vibration (3.1 rad/s)'.
   pure function rate_words(self, unit) result(words)
      class(choice_type), intent(in) :: self
      !> Name of the unit of time
      character(*), intent(in) :: unit
      character(:), allocatable :: words
      if (self%decay > self%fastest) then
         words = 'the fastest decay ('//as_text(self%decay, 2)//' 1/'//unit//')'
      else
         words = 'the fastest vibration ('//as_text(self%fastest, 2)//' rad/'//unit//')'
      end if
   end function rate_words

   !> Whether steps that are bound to the fastest rate cost no more than those of an implicit method.
   pure logical function suits_adams(found, tolerance) result(suits)
      type(choice_type), intent(in) :: found
      real(wp), intent(in) :: tolerance
      real(wp) :: limit, resolved
      ! A step of RADAU costs as much as ten of ADAMS; those of ADAMS are bound to the fastest rate
      limit = 10*tolerance**(-0.125_wp)
      ! Ringing that is ten thousand times what RADAU lets pass in a step it must follow all too closely: ADAMS does so for less
      resolved = 1.0e3_wp*tolerance**0.8_wp
      suits = found%rate() <= limit*found%motion .or. (found%ringing > resolved .and. found%decay <= limit*found%motion)
   end function suits_adams

   !> Decides from the indicators.
   pure subroutine decide(found, powered, dynamics, unit, integrator, reason)
      type(choice_type), intent(in) :: found
      !> True if something puts energy in or takes it out, or CONSERVING cannot be used
      logical, intent(in) :: powered
      type(dynamics_type), intent(in) :: dynamics
      !> Name of the unit of time
      character(*), intent(in) :: unit
      character(:), allocatable, intent(out) :: integrator, reason
      !> Turns of the motion beyond which the energy of a conservative scene counts more than its phase
      real(wp), parameter :: long = 1.0e3_wp
      !> Tolerance below which the phase counts as well, which a method of order two loses
      real(wp), parameter :: loose = 5.0e-4_wp
      character(:), allocatable :: ratio
      ratio = 'nothing vibrates'
      if (found%rate() > 0.0_wp) ratio = found%rate_words(unit)//' is '//as_text(found%rate()/found%motion, 2)// &
         & ' times as fast as the motion'
      if (.not. powered .and. found%motion*(dynamics%end - dynamics%start) > 2*acos(-1.0_wp)*long &
         & .and. dynamics%tolerance > loose) then
         integrator = 'CONSERVING'
         reason = 'nothing puts energy in or takes it out, and the run is long'
      else if (.not. suits_adams(found, dynamics%tolerance)) then
         integrator = 'RADAU'
         reason = ratio//', and the tolerance does not ask for it'
      else if (suits_adams(choice_type(found%fastest, found%decay, found%motion), dynamics%tolerance)) then
         integrator = 'ADAMS'
         reason = ratio//': not stiff at this tolerance'
      else
         integrator = 'ADAMS'
         reason = ratio//', but the start excites it and the tolerance asks for it'
      end if
   end subroutine decide

   !> Finds what the choice depends on at a state.
   subroutine look_at_state(system, work, t, q, v, found)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      type(choice_type), intent(out) :: found
      type(error_type), allocatable :: error
      !> Part of the fastest vibration below which RADAU follows for less what binds ADAMS to the fastest
      real(wp), parameter :: slow = 0.1_wp
      real(wp), allocatable :: a(:), reversed(:)
      allocate (a(size(q)), reversed(size(q)))
      a = 0.0_wp
      call linearise(system, work, t, q, error)
      if (.not. allocated(error)) then
         reversed = -v
         call accelerations(system, work, q, reversed, a)
         reversed = a
         call accelerations(system, work, q, v, a)
      end if
      found%motion = motion_rate(system, q, v, a)
      if (.not. allocated(error)) then
         call find_fastest(system, work, t, q, v, a, found)
         found%decay = max(found%decay, odd_rate(system, v, reversed - a))
      end if
      found%ringing = ringing(system, a, max(10*found%motion, slow*found%fastest))
   end subroutine look_at_state

   !> Rate at which what depends on the sense of the motion would stop it: a law that jumps from one end to the other between v and
   !> -v has no slope at either, eq. (5.61). [1/time]
   pure real(wp) function odd_rate(system, v, change) result(rate)
      type(system_type), intent(in) :: system
      !> Velocities, and by how much more they would grow if they were reversed (nq)
      real(wp), intent(in) :: v(:), change(:)
      real(wp) :: moved, pushed, unit
      integer :: i, first
      moved = 0.0_wp
      pushed = 0.0_wp
      unit = system%model%length
      do i = 1, size(system%layout%q)
         if (system%layout%carries(i)) cycle
         first = system%layout%q(i)
         moved = moved + sum(v(first:first + 1)**2)
         pushed = pushed + sum(change(first:first + 1)**2)
         if (.not. system%layout%framed(i)) cycle
         moved = moved + unit**2*sum(v(first + 2:first + 3)**2)
         pushed = pushed + unit**2*sum(change(first + 2:first + 3)**2)
      end do
      rate = 0.0_wp
      if (moved > 0.0_wp) rate = 0.5_wp*sqrt(pushed/moved)
   end function odd_rate

   !> Rate of the motion: that of the frames and drivers, and the slowest vibration of each body; of a beam in s pieces that of the
   !> whole, whose length is s times that of a piece. [rad/time]
   pure real(wp) function motion_rate(system, q, v, a) result(rate)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:), v(:), a(:)
      integer :: i, pieces(2)
      associate (dynamics => system%model%dynamics)
         rate = max(2*acos(-1.0_wp)/(dynamics%end - dynamics%start), frame_rate(system, q, v, a))
      end associate
      do i = 1, size(system%layout%q)
         if (system%layout%n(i) == 0) cycle
         pieces = pieces_of(system%model, i)
         rate = max(rate, sqrt(minval(system%model%bodies(i)%reduced%omega2))/(pieces(2) - pieces(1) + 1)**2)
      end do
   end function motion_rate

   !> The fastest rotation, speeds and accelerations on the scene's length. [rad/time]
   pure real(wp) function frame_rate(system, q, v, a) result(rate)
      type(system_type), intent(in) :: system
      !> Coordinates, velocities and accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      integer, parameter :: looks = 50
      type(jet_type) :: theta
      integer :: i, k, first
      real(wp) :: t, unit
      associate (dynamics => system%model%dynamics, length => system%model%length)
         rate = 0.0_wp
         do i = 1, size(system%layout%q)
            if (system%layout%carries(i)) cycle
            first = system%layout%q(i)
            rate = max(rate, norm2(v(first:first + 1))/length, sqrt(norm2(a(first:first + 1))/length))
            if (system%layout%framed(i)) rate = max(rate, abs(cross(q(first + 2:first + 3), v(first + 2:first + 3))), &
               & sqrt(norm2(a(first + 2:first + 3))))
         end do
         do i = 1, size(system%model%drivers)
            if (.not. acts(system%model%drivers(i)%switch, system%on)) cycle
            do k = 0, looks
               t = dynamics%start + (dynamics%end - dynamics%start)*(real(k, wp)/looks)
               theta = driven_motion(system%model%drivers(i), t)
               unit = length
               if (any(system%model%drivers(i)%kind == [driver_angle, driver_joint_angle])) unit = 1.0_wp
               rate = max(rate, abs(theta%first)/unit, sqrt(abs(theta%second)/unit))
            end do
         end do
      end associate
   end function frame_rate

   !> Amplitude of vibrations faster than the motion that the accelerations of the start leave, relative to the scales of
   !> limber_integrator_error_scales.
   pure real(wp) function ringing(system, a, slowest) result(amplitude)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: a(:)
      !> Slower ones do not count [rad/time]
      real(wp), intent(in) :: slowest
      integer :: i, k, first
      amplitude = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i) + 3
         associate (body => system%model%bodies(i))
            do k = 1, body%reduced%n
               if (body%reduced%omega2(k) < slowest**2) cycle
               amplitude = max(amplitude, abs(a(first + k))/body%reduced%omega2(k)/(1.0e-3_wp*body%size/body%largest_shape))
            end do
         end associate
      end do
   end function ringing

   !> Fastest vibration and fastest decay about a state with the constraints kept, by the power method on M^-1 K and M^-1 D: the
   !> larger one is within a factor of two of the largest eigenvalue of the system of first order, eq. (5.61).
   subroutine find_fastest(system, work, t, q, v, a, found)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      type(choice_type), intent(inout) :: found
      type(tangent_type) :: tangent
      type(error_type), allocatable :: error
      real(wp), allocatable :: push(:), rates(:), motion(:)
      associate (nw => system%layout%nw)
         allocate (push(nw), motion(nw), rates(system%nc))
         call new_tangent(system, tangent)
         call rates_of(system%layout, q, a, push)
         call motion_residual(system, work, t, q, v, push, work%lambda, motion, rates)
         call linearise_motion(system, work, tangent, q, v, push, work%lambda)
         call linearise(system, work, t, q, error)
         if (allocated(error)) return
      end associate
      found%fastest = sqrt(largest_factor(system, work, tangent, .false.))
      found%decay = largest_factor(system, work, tangent, .true.)
   end subroutine find_fastest

   !> Factor by which M^-1 K or M^-1 D stretches what it stretches most; `linearise` comes first.
   real(wp) function largest_factor(system, work, tangent, damping) result(factor)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(tangent_type), intent(in) :: tangent
      !> Whether D is meant
      logical, intent(in) :: damping
      integer, parameter :: rounds = 12
      real(wp) :: x(system%layout%nw), force(system%layout%nw), push(system%layout%nw), length
      integer :: i, k
      factor = 0.0_wp
      x = [(1.0_wp + 0.5_wp*modulo(0.618_wp*k, 1.0_wp), k=1, size(x))]
      do i = 1, rounds
         force = 0.0_wp
         if (damping) then
            call times_damping(system, tangent, 1.0_wp, x, force)
         else
            call times_stiffness(system, tangent, 1.0_wp, x, force)
         end if
         call accelerate(system, work, force, push)
         length = norm2(push)
         if (.not. length > 0.0_wp) return
         factor = length/norm2(x)
         x = push/length
      end do
   end function largest_factor

end module limber_scene_integrator_choice
