!> Channels that err because bending draws bodies in. Positions, displacements, velocities, accelerations and momenta that channels
!> ask for: what the shortening of all beams and frames, with its rates, does to them, as their joints let the bodies follow, and
!> how large they are. Floor: monitor. Source: doc/theory, eq. (7.24).
!>
!>     call start_drawn_channels(self, system, watched)              ! allocates
!>     self%field(:, :, slot), self%moves%inertia(:, :, body) = ...        ! of each body that takes part, in a state
!>     call observe_drawn_channels(self, system, work, t, q, v, a)   ! self%channels
module limber_monitor_drawn_channels
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_monitor_drawn_motions, only: drawn_motions_type, start_drawn_motions, follow_bodies, moved, lacking_momentum
   use limber_model_model, only: ground, place_on_line
   use limber_model_quantities, only: quantities, quantity_angular_momentum, quantity_ax, quantity_ay, quantity_displacement, &
      & quantity_momentum_x, quantity_momentum_y, quantity_sliding_speed, quantity_u1, quantity_u2, quantity_vx, quantity_vy, &
      & quantity_x, quantity_y
   use limber_multibody_momentum, only: total_momentum
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_point_motion, only: point_position, point_velocity, point_acceleration
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: drawn_channels_type, drawn_channel_type, start_drawn_channels, observe_drawn_channels, join_drawn_channels, drawn_part

   !> A quantity that a channel asks for
   type :: drawn_channel_type
      !> As a deck has it: u1(beam.end)
      character(100) :: name = ''
      !> Kind of the quantity, index of its point or joint
      integer :: kind = 0, of = 0
      !> Body whose bending it shows; 0: of any that take part
      integer :: body = 0
      !> Size of that body, or of the largest one [length]
      real(wp) :: length = 0.0_wp
      !> Largest error and its time, largest value, and largest one along both axes together
      real(wp) :: error = 0.0_wp, time = 0.0_wp, value = 0.0_wp, motion = 0.0_wp
      !> What is drawn in at most anywhere, of the same unit
      real(wp) :: drawn = 0.0_wp
      !> Position without deflection, and elongation, when it was first observed [length]
      real(wp) :: from(2) = 0.0_wp
      logical :: seen = .false.
   end type drawn_channel_type

   !> Those of a scene
   type :: drawn_channels_type
      type(drawn_channel_type), allocatable :: channels(:)
      !> Bodies that take part
      type(drawn_motions_type) :: moves
      !> Largest displacement by the shortening so far, its largest rate and acceleration, and its largest momentum
      real(wp) :: most_drawn(0:3) = 0.0_wp
   contains
      procedure :: exchange => exchange_drawn
   end type drawn_channels_type

contains

   !> Lists the channels, which are none before, and the bodies that take part: those that bend and those that joints connect with
   !> them.
   subroutine start_drawn_channels(self, system, watched)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Whether the shortening of a body is known (bodies)
      logical, intent(in) :: watched(:)
      type(drawn_channel_type) :: channel
      integer :: i, j, n, pass
      if (.not. any(watched)) return
      do pass = 1, 2
         n = 0
         do i = 1, size(system%model%channels)
            do j = 1, size(system%model%channels(i)%quantities)
               associate (quantity => system%model%channels(i)%quantities(j))
                  if (quantity%of_load .or. quantity%of_coupler) cycle
                  channel = new_channel(quantity%kind, quantity%of)
               end associate
               if (channel%kind == 0) cycle
               n = n + 1
               if (pass == 2) self%channels(n) = channel
            end do
         end do
         if (pass == 2) exit
         deallocate (self%channels)
         allocate (self%channels(n))
      end do
      if (n == 0) return
      call start_drawn_motions(self%moves, system, watched, [(any(self%channels%body == i), i=1, size(watched))], &
         & any(self%channels%body == 0), shown_points(self, system))

   contains

      !> A channel; its kind is 0 if it is none of these.
      function new_channel(kind, of) result(channel)
         integer, intent(in) :: kind, of
         type(drawn_channel_type) :: channel
         integer :: body
         select case (kind)
         case (quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_ax, quantity_ay, quantity_u1, quantity_u2)
            body = system%model%points(of)%body
            if (body == ground) return
            if (watched(body)) channel%body = body
            if (any(kind == [quantity_u1, quantity_u2]) .and. channel%body == 0) return
            channel%name = trim(quantities(kind)%name)//'('//trim(system%model%points(of)%name)//')'
         case (quantity_displacement, quantity_sliding_speed)
            if (system%model%joints(of)%place /= place_on_line) return
            channel%name = trim(quantities(kind)%name)//'('//trim(system%model%joints(of)%name)//')'
         case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum)
            channel%name = trim(quantities(kind)%name)//'(system)'
         case default
            return
         end select
         channel%kind = kind
         channel%of = of
         channel%length = maxval(system%model%bodies%size, mask=watched)
         if (channel%body > 0) channel%length = system%model%bodies(channel%body)%size
      end function new_channel

   end subroutine start_drawn_channels

   !> Points that the channels show.
   function shown_points(self, system) result(points)
      type(drawn_channels_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, allocatable :: points(:)
      integer :: i
      allocate (points(0))
      do i = 1, size(self%channels)
         select case (self%channels(i)%kind)
         case (quantity_displacement, quantity_sliding_speed)
            points = [points, system%model%joints(self%channels(i)%of)%points]
         case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum)
         case default; points = [points, self%channels(i)%of]
         end select
      end do
   end function shown_points

   !> Takes a state, with the displacements of it, into the largest values.
   subroutine observe_drawn_channels(self, system, work, t, q, v, a)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Jacobians are those of the state
      type(workspace_type), intent(in) :: work
      !> Time
      real(wp), intent(in) :: t
      !> Coordinates, velocities, accelerations (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      integer :: i, order
      logical :: done
      if (size(self%channels) == 0) return
      call follow_bodies(self%moves, system, work, q, v, a, done)
      if (.not. done) return
      do order = 0, 2
         self%most_drawn(order) = max(self%most_drawn(order), maxval(abs(self%moves%field(1:2, order, :))))
      end do
      self%most_drawn(3) = max(self%most_drawn(3), maxval(abs(self%moves%inertia(1:2, 1, :))))
      do i = 1, size(self%channels)
         call observe_channel(self, system, self%channels(i), t, q, v, a)
      end do
   end subroutine observe_drawn_channels

   !> Takes the error and the value of one channel in.
   subroutine observe_channel(self, system, channel, t, q, v, a)
      type(drawn_channels_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(drawn_channel_type), intent(inout) :: channel
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      real(wp), intent(in) :: t
      real(wp) :: lacking(2), shown(2), e(3), total(3), axis(2)
      integer :: part, order
      part = 1
      channel%drawn = self%most_drawn(order_of(channel%kind))
      if (channel%kind == quantity_angular_momentum) channel%drawn = channel%drawn*channel%length
      select case (channel%kind)
      case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum)
         if (any(self%moves%stuck)) return
         e = lacking_momentum(self%moves, system, q, v, a)
         call total_momentum(system, q, v, total)
         lacking = e(1:2)
         shown = total(1:2)
         if (channel%kind == quantity_momentum_y) part = 2
         if (channel%kind == quantity_angular_momentum) then
            lacking = [e(3), 0.0_wp]
            shown = [total(3), 0.0_wp]
         end if
      case (quantity_displacement, quantity_sliding_speed)
         if (any(self%moves%stuck)) return
         associate (joint => system%model%joints(channel%of))
            axis = line_of(system, channel%of, q)
            order = order_of(channel%kind)
            lacking = [dot_product(axis, error_at(joint%points(1), order) - error_at(joint%points(2), order)), 0.0_wp]
            shown = [dot_product(axis, value_at(joint%points(1), order) - value_at(joint%points(2), order)), 0.0_wp]
            if (order == 0) call count_from(shown, [0.0_wp, 0.0_wp])
         end associate
      case default
         associate (point => system%model%points(channel%of))
            if (self%moves%stuck(point%body)) return
            if (channel%body == 0 .and. any(self%moves%stuck)) return
            if (any(channel%kind == [quantity_y, quantity_vy, quantity_ay, quantity_u2])) part = 2
            if (any(channel%kind == [quantity_u1, quantity_u2])) then
               lacking = 0.0_wp
               if (self%moves%slot(channel%of) > 0) lacking = self%moves%field(1:2, 0, self%moves%slot(channel%of))
               shown = deflection(channel%of)
            else
               order = order_of(channel%kind)
               lacking = error_at(channel%of, order)
               shown = value_at(channel%of, order)
               axis = 0.0_wp
               if (channel%body > 0) axis = along(deflection(channel%of), q(system%layout%q(point%body) + 2:))
               if (order == 0) call count_from(shown, axis)
            end if
         end associate
      end select
      if (abs(lacking(part)) > channel%error) then
         channel%error = abs(lacking(part))
         channel%time = t
      end if
      channel%value = max(channel%value, abs(shown(part)), abs(shown(part) + lacking(part)))
      channel%motion = max(channel%motion, norm2(shown), norm2(shown + lacking))

   contains

      !> Error of a point, of its velocity or acceleration.
      function error_at(point, order) result(error)
         integer, intent(in) :: point, order
         real(wp) :: error(2), e(3)
         e = moved(self%moves, system, point, q, v, a, order, .true.)
         error = e(1:2)
      end function error_at

      !> Position, velocity or acceleration.
      function value_at(point, order) result(value)
         integer, intent(in) :: point, order
         real(wp) :: value(2)
         select case (order)
         case (0); value = point_position(system%model, system%layout, system%model%points(point), q)
         case (1); value = point_velocity(system%model, system%layout, system%model%points(point), q, v)
         case default; value = point_acceleration(system%model, system%layout, system%model%points(point), q, v, a)
         end select
      end function value_at

      !> Displacement in the frame.
      function deflection(point) result(u)
         integer, intent(in) :: point
         real(wp) :: u(2)
         integer :: k, first
         u = 0.0_wp
         first = system%layout%q(system%model%points(point)%body) + 3
         do k = 1, size(system%model%points(point)%phi, 2)
            u = u + system%model%points(point)%phi(:, k)*q(first + k)
         end do
      end function deflection

      !> Change of a position since it was first observed, there without its deflection.
      subroutine count_from(position, bent)
         real(wp), intent(inout) :: position(2)
         real(wp), intent(in) :: bent(2)
         if (.not. channel%seen) channel%from = position - bent
         channel%seen = .true.
         position = position - channel%from
      end subroutine count_from

   end subroutine observe_channel

   !> 0, 1, 2 of a position, velocity, acceleration; 3 of a momentum.
   pure integer function order_of(kind)
      integer, intent(in) :: kind
      select case (kind)
      case (quantity_vx, quantity_vy, quantity_sliding_speed); order_of = 1
      case (quantity_ax, quantity_ay); order_of = 2
      case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum); order_of = 3
      case default; order_of = 0
      end select
   end function order_of

   !> Direction of the line of a joint in space, its second section taken as its frame (2).
   pure function line_of(system, joint, q) result(axis)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), contiguous, intent(in) :: q(:)
      real(wp) :: axis(2)
      associate (spec => system%model%joints(joint), point => system%model%points(system%model%joints(joint)%points(2)))
         axis = [cos(spec%angle - point%lean), sin(spec%angle - point%lean)]
         if (point%body == ground) return
         if (system%layout%framed(point%body)) axis = along(axis, q(system%layout%q(point%body) + 2:))
      end associate
   end function line_of

   !> Error of a channel as a part of its largest value; nought of what is not worth a word: a displacement that is none beside the
   !> size of the body, what errs by a small part of the motion along both axes, and what joints hold, to round-off.
   pure real(wp) function drawn_part(channel) result(part)
      type(drawn_channel_type), intent(in) :: channel
      !> Of the size of the body; of the motion; of what is drawn in elsewhere
      real(wp), parameter :: least = 1.0e-9_wp, small = 1.0e-3_wp, held = 1.0e-6_wp
      part = 0.0_wp
      if (order_of(channel%kind) == 0 .and. .not. channel%error > least*channel%length) return
      if (all(channel%kind /= [quantity_u1, quantity_u2]) .and. .not. channel%error > small*channel%motion) return
      if (channel%error > held*channel%drawn .and. channel%value > 0.0_wp) part = channel%error/channel%value
   end function drawn_part

   !> Joins the maxima of an analysis to those of the ones before it.
   subroutine join_drawn_channels(part, whole)
      type(drawn_channels_type), intent(in) :: part
      type(drawn_channels_type), intent(inout) :: whole
      integer :: i
      do i = 1, size(part%channels)
         associate (from => part%channels(i), to => whole%channels(i))
            if (from%error > to%error) to%time = from%time
            to%error = max(to%error, from%error)
            to%value = max(to%value, from%value)
            to%motion = max(to%motion, from%motion)
            to%drawn = max(to%drawn, from%drawn)
         end associate
      end do
   end subroutine join_drawn_channels

   !> Saves or restores its memory.
   subroutine exchange_drawn(self, snapshot)
      class(drawn_channels_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      do i = 1, size(self%channels)
         call snapshot%exchange('error', self%channels(i)%error)
         call snapshot%exchange('time', self%channels(i)%time)
         call snapshot%exchange('value', self%channels(i)%value)
         call snapshot%exchange('motion', self%channels(i)%motion)
         call snapshot%exchange('drawn', self%channels(i)%drawn)
         call snapshot%exchange('from', self%channels(i)%from)
         call snapshot%exchange('seen', self%channels(i)%seen)
      end do
      call snapshot%exchange('most_drawn', self%most_drawn)
      ! Not saved: moves
   end subroutine exchange_drawn

end module limber_monitor_drawn_channels
