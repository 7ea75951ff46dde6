!> State over a step of the energy-momentum scheme. The state at its start, the end that the increments y = [dr; alpha; deta] of all
!> bodies lead to, in the layout of the rates, and the kinematics of the mean. The rates are those of the frame's axes, [S^T r';
!> omega; eta']; those of a point mass stay in the fixed axes. `limber_multibody_discrete_motion` and
!> `limber_multibody_articulated_step` have its equations. No allocation but in `new_step`. Floor: multibody. Source: doc/theory,
!> eqs. (5.21)-(5.25).
module limber_multibody_discrete_step
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: turn, along, into_frame
   use limber_multibody_beam_axis, only: centreline_type
   use limber_multibody_constraint, only: jacobian_type
   use limber_multibody_beam_discrete_step, only: exact_step_type, new_exact_step, place_mean, mean_turn, exact_momentum
   use limber_multibody_kinematics, only: kinematics_type, marker_type, new_kinematics, place_drives, place_frames, settle_angles
   use limber_multibody_layout, only: layout_type
   use limber_multibody_marker_motion, only: place_exact_shapes
   use limber_multibody_markers, only: angle_change
   use limber_multibody_momentum, only: body_momentum
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: discrete_step_type, new_step, begin_step, find_momenta, find_end, find_mean, frame_rates, fixed_rates, gauss

   !> Gauss points of a step: to degree three, that of the elastic force
   real(wp), parameter :: gauss(2) = [0.5_wp - sqrt(3.0_wp)/6, 0.5_wp + sqrt(3.0_wp)/6]

   !> Scratch of a body
   type :: step_body_type
      !> Coordinates between the ends (n), elastic tangent (n,n), first moments of mass that units of the coordinates make in the
      !> mean, in the axes of the frame (2,n)
      real(wp), allocatable :: eta(:), tangent(:, :), moment(:, :)
      !> Which of the centrelines an exact beam has, else 0, and what the step makes of it
      integer :: line = 0
      type(exact_step_type), allocatable :: exact
   end type step_body_type

   !> A step from a state
   type :: discrete_step_type
      !> Time at its start, its length, time at its end: their sum but for rounding
      real(wp) :: t = 0.0_wp, h = 0.0_wp, final = 0.0_wp
      !> State at its start: coordinates (nq), rates and momenta in the axes of the frames (nw)
      real(wp), allocatable :: q(:), b(:), p(:)
      !> The end that is tried: coordinates, rates, momenta
      real(wp), allocatable :: new_q(:), new_b(:), new_p(:)
      !> Kinematics at the start, and of the mean; allocatable, since gfortran 12 gives back the parts of the first only otherwise
      type(kinematics_type), allocatable :: start, mean
      !> Jacobians of the mean (2, constraints)
      type(jacobian_type), allocatable :: jacobians(:, :)
      type(step_body_type), allocatable :: bodies(:)
   contains
      procedure :: exchange => exchange_step
   end type discrete_step_type

contains

   !> Room.
   subroutine new_step(system, work, step)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(discrete_step_type), intent(inout) :: step
      integer :: i
      associate (nq => system%layout%nq, nw => system%layout%nw)
         allocate (step%q(nq), step%new_q(nq), step%b(nw), step%new_b(nw), step%p(nw), step%new_p(nw))
      end associate
      allocate (step%start, step%mean)
      step%start = new_kinematics(system%model, system%marker_points, system%angles, system%bends)
      ! Turns that are behind the angles of an analysis before
      step%start%angles%anchor = work%kinematics%angles%anchor
      step%mean = step%start
      allocate (step%jacobians(2, size(system%constraints)), step%bodies(size(system%layout%q)))
      step%jacobians = work%jacobians
      do i = 1, size(step%bodies)
         associate (n => system%layout%n(i))
            allocate (step%bodies(i)%eta(n), step%bodies(i)%tangent(n, n))
         end associate
         step%bodies(i)%moment = system%model%bodies(i)%reduced%c
      end do
      do i = 1, size(step%mean%beams)
         associate (own => step%bodies(step%mean%beams(i)))
            own%line = i
            allocate (own%exact)
            call new_exact_step(step%mean%lines(i), own%exact)
         end associate
      end do
   end subroutine new_step

   !> Places the start at (t, q), rates b.
   subroutine begin_step(system, step, t, h, final, q, b)
      type(system_type), intent(in) :: system
      type(discrete_step_type), intent(inout) :: step
      !> Time, length, time at the end
      real(wp), intent(in) :: t, h, final
      !> Coordinates (nq), rates in the axes of the frames (nw)
      real(wp), contiguous, intent(in) :: q(:), b(:)
      step%t = t
      step%h = h
      step%final = final
      step%q = q
      step%b = b
      call place_frames(system%model, system%layout, t, q, step%start)
      call settle_angles(step%start, .false.)
      call place_drives(system%model, t + 0.5_wp*h, step%mean)
      step%mean%span = h
      call find_momenta(system, step%start%lines, q, b, step%p)
   end subroutine begin_step

   !> Momenta of rates, both in the axes of the frames.
   pure subroutine find_momenta(system, lines, q, b, p)
      type(system_type), intent(in) :: system
      !> Of the exact beams, placed
      type(centreline_type), intent(inout) :: lines(:)
      !> Coordinates (nq), rates (nw), momenta (nw)
      real(wp), intent(in) :: q(:), b(:)
      real(wp), intent(inout) :: p(:)
      integer :: i, first, last, at, line
      line = 0
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         associate (body => system%model%bodies(i)%reduced)
            if (body%is_exact) then
               line = line + 1
               call exact_momentum(lines(line), b(at:at + 2 + body%n), p(at:at + 2 + body%n))
            else if (system%layout%framed(i)) then
               first = system%layout%q(i) + 4
               last = at + 2 + body%n
               call body_momentum(body, q(first:first + body%n - 1), b(at:last), p(at:last))
            else
               p(at:at + 1) = body%mass*b(at:at + 1)
            end if
         end associate
      end do
   end subroutine find_momenta

   !> Rates in the axes of the frames from those in the fixed axes.
   pure subroutine frame_rates(layout, q, w, b)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq), rates (nw)
      real(wp), intent(in) :: q(:), w(:)
      real(wp), intent(inout) :: b(:)
      real(wp) :: part(2)
      integer :: i, at
      b = w
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         part = into_frame(w(at:at + 1), q(layout%q(i) + 2:layout%q(i) + 3))
         b(at:at + 1) = part
      end do
   end subroutine frame_rates

   !> And back.
   pure subroutine fixed_rates(layout, q, b, w)
      type(layout_type), intent(in) :: layout
      real(wp), intent(in) :: q(:), b(:)
      real(wp), intent(inout) :: w(:)
      real(wp) :: part(2)
      integer :: i, at
      w = b
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         part = along(b(at:at + 1), q(layout%q(i) + 2:layout%q(i) + 3))
         w(at:at + 1) = part
      end do
   end subroutine fixed_rates

   !> Coordinates and rates at the end of a step: eq. (5.21).
   pure subroutine find_end(layout, step, y)
      type(layout_type), intent(in) :: layout
      type(discrete_step_type), intent(inout) :: step
      !> Increments (nw)
      real(wp), intent(in) :: y(:)
      real(wp) :: mean(2), alpha, along_u, across_u, size_of
      integer :: i, from, at
      do i = 1, size(layout%q)
         from = layout%q(i)
         at = layout%w(i)
         step%new_q(from:from + 1) = step%q(from:from + 1) + y(at:at + 1)
         if (.not. layout%framed(i)) then
            step%new_b(at:at + 1) = 2*y(at:at + 1)/step%h - step%b(at:at + 1)
            cycle
         end if
         alpha = y(at + 2)
         mean = into_frame(y(at:at + 1), step%q(from + 2:from + 3))
         mean = (mean - 0.5_wp*alpha*turn(mean))/step%h
         step%new_b(at:at + 1) = 2*mean - step%b(at:at + 1)
         step%new_b(at + 2:at + 2 + layout%n(i)) = 2*y(at + 2:at + 2 + layout%n(i))/step%h - step%b(at + 2:at + 2 + layout%n(i))
         along_u = 1 - 0.25_wp*alpha**2
         across_u = alpha
         associate (u => step%new_q(from + 2:from + 3), u0 => step%q(from + 2:from + 3))
            u(1) = along_u*u0(1) - across_u*u0(2)
            u(2) = along_u*u0(2) + across_u*u0(1)
            size_of = sqrt(u(1)**2 + u(2)**2)
            u = u/size_of
         end associate
         step%new_q(from + 4:from + 3 + layout%n(i)) = step%q(from + 4:from + 3 + layout%n(i)) + y(at + 3:at + 2 + layout%n(i))
      end do
   end subroutine find_end

   !> Kinematics of the mean, eqs. (2.58), (5.25).
   pure subroutine find_mean(system, step, final, y)
      type(system_type), intent(in) :: system
      type(discrete_step_type), intent(inout) :: step
      !> Kinematics at the end
      type(kinematics_type), intent(in) :: final
      !> Increments (nw)
      real(wp), intent(in) :: y(:)
      integer :: i, k, m, at
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         associate (frame => step%mean%frames(i), a => step%start%frames(i), b => final%frames(i))
            frame%position = 0.5_wp*(a%position + b%position)
            frame%velocity = y(at:at + 1)/step%h
            if (.not. system%layout%framed(i)) cycle
            frame%u = 0.5_wp*(a%u + b%u)
            frame%omega = y(at + 2)/step%h
            frame%rate = frame%omega*turn(frame%u)
         end associate
         if (step%bodies(i)%line > 0) call find_mean_line(system%layout, step, i, y)
      end do
      do m = 1, size(step%mean%markers)
         associate (marker => step%mean%markers(m), a => step%start%markers(m), b => final%markers(m))
            if (marker%body == ground) cycle
            associate (frame => step%mean%frames(marker%body))
               marker%position = 0.5_wp*(a%position + b%position)
               marker%lever = 0.5_wp*(a%lever + b%lever)
               marker%velocity = frame%omega*marker%lever
               if (.not. marker%direction) marker%velocity = frame%velocity + marker%velocity
               if (marker%line > 0) call find_mean_shape(system, step, marker, y)
               do k = 1, size(marker%shape, 2)
                  if (marker%line == 0) marker%shape(:, k) = 0.5_wp*(1 + 0.25_wp*(frame%omega*step%h)**2) &
                     & *(a%shape(:, k) + b%shape(:, k))
                  marker%velocity = marker%velocity + marker%shape(:, k)*(y(system%layout%w(marker%body) + 2 + k)/step%h)
               end do
            end associate
         end associate
      end do
      do m = 1, size(step%mean%angles)
         step%mean%angles(m)%value = final%angles(m)%value - 0.5_wp*angle_change(step%mean, m)
      end do
      do m = 1, size(step%mean%bends)
         associate (bend => step%mean%bends(m))
            bend%eta = 0.5_wp*(step%start%bends(m)%eta + final%bends(m)%eta)
            at = system%layout%w(bend%body) + 3
            bend%rate = y(at:at + size(bend%rate) - 1)/step%h
         end associate
      end do
   end subroutine find_mean

   !> The axis of an exact beam in the mean, and the first moments of mass that its coordinates make.
   pure subroutine find_mean_line(layout, step, body, y)
      type(layout_type), intent(in) :: layout
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: body
      real(wp), intent(in) :: y(:)
      integer :: first, at, n, k
      first = layout%q(body) + 4
      at = layout%w(body) + 3
      n = layout%n(body)
      associate (own => step%bodies(body), line => step%mean%lines(step%bodies(body)%line))
         own%eta = step%q(first:first + n - 1) + 0.5_wp*y(at:at + n - 1)
         call place_mean(own%exact, line, own%eta, y(at:at + n - 1), step%h)
         do k = 1, n
            own%moment(:, k) = [sum(line%mass*line%dx(:, k)), sum(line%mass*line%dy(:, k))]
         end do
      end associate
   end subroutine find_mean_line

   !> What the coordinates of an exact beam move a point or direction of it by, times the increments its change in the step.
   pure subroutine find_mean_shape(system, step, marker, y)
      type(system_type), intent(in) :: system
      type(discrete_step_type), intent(in) :: step
      type(marker_type), intent(inout) :: marker
      real(wp), intent(in) :: y(:)
      real(wp) :: stretched(2), vector(2)
      integer :: k, at, n
      stretched = step%mean%frames(marker%body)%u*(1 + 0.25_wp*(step%mean%frames(marker%body)%omega*step%h)**2)
      if (.not. marker%direction) then
         call place_exact_shapes(step%mean%lines(marker%line), stretched, marker)
         return
      end if
      at = system%layout%w(marker%body) + 3
      n = system%layout%n(marker%body)
      associate (psi => system%model%points(marker%point)%psi, eta => step%bodies(marker%body)%eta)
         vector = mean_turn(dot_product(psi, eta), 0.5_wp*dot_product(psi, y(at:at + n - 1)))
         vector = turn(along(along(marker%p0, vector), stretched))
         do k = 1, size(marker%shape, 2)
            marker%shape(:, k) = psi(k)*vector
         end do
      end associate
   end subroutine find_mean_shape

   !> Saves or restores its memory.
   subroutine exchange_step(self, snapshot)
      class(discrete_step_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i, j
      call snapshot%exchange('t', self%t)
      call snapshot%exchange('h', self%h)
      call snapshot%exchange('final', self%final)
      call snapshot%keep('q', self%q)
      call snapshot%keep('b', self%b)
      call snapshot%keep('p', self%p)
      call snapshot%keep('new_q', self%new_q)
      call snapshot%keep('new_b', self%new_b)
      call snapshot%keep('new_p', self%new_p)
      call self%start%exchange(snapshot)
      call self%mean%exchange(snapshot)
      do i = 1, size(self%jacobians, 2)
         do j = 1, 2
            call self%jacobians(j, i)%exchange(snapshot)
         end do
      end do
      do i = 1, size(self%bodies)
         call snapshot%keep('eta', self%bodies(i)%eta)
         call snapshot%keep('tangent', self%bodies(i)%tangent)
      end do
   end subroutine exchange_step

end module limber_multibody_discrete_step
