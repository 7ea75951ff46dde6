!> Channels that err because bending draws bodies in. Positions, displacements, velocities, accelerations and momenta that channels
!> ask for: what the shortening of all beams and frames, with its rates, does to them, as their joints let the bodies follow, and
!> how large they are. Floor: monitor. Source: doc/theory, eq. (7.24).
!>
!>     call start_drawn_channels(self, system, watched)              ! allocates
!>     self%field(:, :, slot), self%inertia(:, :, body) = ...        ! of each body that takes part, in a state
!>     call observe_drawn_channels(self, system, work, t, q, v, a)   ! self%channels
module limber_monitor_drawn_channels
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgetrf, dgetrs
   use limber_base_snapshot, only: snapshot_type
   use limber_monitor_body_surveys, only: is_base
   use limber_model_model, only: ground, place_on_line
   use limber_model_quantities, only: quantities, quantity_angular_momentum, quantity_ax, quantity_ay, quantity_displacement, &
      & quantity_momentum_x, quantity_momentum_y, quantity_sliding_speed, quantity_u1, quantity_u2, quantity_vx, quantity_vy, &
      & quantity_x, quantity_y
   use limber_multibody_body, only: centre_moment, rigid_mass
   use limber_multibody_momentum, only: total_momentum
   use limber_multibody_plane_vectors, only: along, cross, turn
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
      !> Bodies that take part: the place before the first motion of each, -1: none; whether bending draws it in (bodies)
      integer, allocatable :: first(:)
      logical, allocatable :: bends(:)
      !> Motions of these bodies, and rows of the constraints among them; the place of each constraint among them (constraints)
      integer :: motions = 0, rows = 0
      integer, allocatable :: row(:)
      !> Points at which displacements are needed (slots), and the slot of each point, 0: none (points)
      integer, allocatable :: points(:), slot(:)
      !> Displacements and rotations there by the shortening, relative to the frame of the body and in its axes, their rates and
      !> accelerations (3, 0:2, slots); these times mass, and moment about the origin (3, 0:2, bodies)
      real(wp), allocatable :: field(:, :, :), inertia(:, :, :)
      !> Motions of the bodies that follow, their rates and accelerations (motions, 0:2)
      real(wp), allocatable :: motion(:, :)
      !> Bodies whose joints do not let them follow now (bodies)
      logical, allocatable :: stuck(:)
      !> Largest displacement by the shortening so far, its largest rate and acceleration, and its largest momentum
      real(wp) :: most_drawn(0:3) = 0.0_wp
      !> Scratch, n = motions + rows: equations (n, n), their factors and behind these a solution (n, n + 1), their scales and
      !> right-hand side (n)
      real(wp), allocatable :: matrix(:, :), factors(:, :), scale(:), side(:)
      integer, allocatable :: pivots(:)
   contains
      procedure :: exchange => exchange_drawn
   end type drawn_channels_type

   !> Most motions and rows
   integer, parameter :: most = 150

contains

   !> Lists the channels, which are none before, and the bodies that take part: those that bend and those that joints connect with
   !> them.
   subroutine start_drawn_channels(self, system, watched)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Whether the shortening of a body is known (bodies)
      logical, intent(in) :: watched(:)
      type(drawn_channel_type) :: channel
      integer :: i, j, n
      n = 0
      if (.not. any(watched)) return
      do i = 1, size(system%model%channels)
         do j = 1, size(system%model%channels(i)%quantities)
            associate (quantity => system%model%channels(i)%quantities(j))
               if (quantity%of_load .or. quantity%of_coupler) cycle
               channel = new_channel(quantity%kind, quantity%of)
               if (channel%kind == 0) cycle
               n = n + 1
            end associate
         end do
      end do
      deallocate (self%channels)
      allocate (self%channels(n))
      n = 0
      do i = 1, size(system%model%channels)
         do j = 1, size(system%model%channels(i)%quantities)
            associate (quantity => system%model%channels(i)%quantities(j))
               if (quantity%of_load .or. quantity%of_coupler) cycle
               channel = new_channel(quantity%kind, quantity%of)
               if (channel%kind == 0) cycle
               n = n + 1
               self%channels(n) = channel
            end associate
         end do
      end do
      if (n == 0) return
      call find_partners(self, system, watched)
      call find_slots(self, system, watched)
      n = self%motions + self%rows
      allocate (self%matrix(n, n), self%factors(n, n + 1), self%scale(n), self%side(n), self%pivots(n))
      allocate (self%motion(self%motions, 0:2), self%stuck(size(watched)))
      self%motion = 0.0_wp
      self%stuck = .false.

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

   !> Bodies that take part, from those that bend on along joints; what drivers move as they know stays where it is, and what is
   !> beyond the most motions.
   subroutine find_partners(self, system, watched)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      logical, intent(in) :: watched(:)
      logical :: wanted(size(watched)), more(size(watched))
      integer :: i, k, side
      allocate (self%first(size(watched)), self%bends(size(watched)), self%row(size(system%constraints)))
      self%first = -1
      self%motions = 0
      do k = 1, 2
         wanted = .false.
         do i = 1, size(self%channels)
            if (self%channels(i)%body > 0) wanted(self%channels(i)%body) = .true.
            if (self%channels(i)%body == 0 .and. k == 2) wanted = wanted .or. watched
         end do
         do i = 1, size(watched)
            if (wanted(i)) call take(i)
         end do
      end do
      do
         more = .false.
         do i = 1, size(system%constraints)
            associate (ends => system%constraints(i)%item%bodies)
               do side = 1, 2
                  if (is_base(system, ends(side)) .or. is_base(system, ends(3 - side))) cycle
                  if (self%first(ends(side)) >= 0 .and. self%first(ends(3 - side)) < 0) more(ends(3 - side)) = .true.
               end do
            end associate
         end do
         k = self%motions
         do i = 1, size(watched)
            if (more(i)) call take(i)
         end do
         if (self%motions == k) exit
      end do
      self%bends = watched .and. self%first >= 0
      self%rows = 0
      self%row = -1
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (.not. (takes_part(self, item%bodies(1)) .or. takes_part(self, item%bodies(2)))) cycle
            if (item%part_of > 0) then
               self%row(i) = self%row(item%part_of)
               cycle
            end if
            self%row(i) = self%rows
            self%rows = self%rows + item%rows
         end associate
      end do

   contains

      subroutine take(body)
         integer, intent(in) :: body
         if (self%first(body) >= 0 .or. system%layout%carries(body)) return
         if (self%motions + system%layout%rates(body) > most) return
         self%first(body) = self%motions
         self%motions = self%motions + system%layout%rates(body)
      end subroutine take

   end subroutine find_partners

   pure logical function takes_part(self, body)
      type(drawn_channels_type), intent(in) :: self
      integer, intent(in) :: body
      takes_part = .false.
      if (body /= ground) takes_part = self%first(body) >= 0
   end function takes_part

   !> Points of bodies that are drawn in: those of channels, and of joints and drivers.
   subroutine find_slots(self, system, watched)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      logical, intent(in) :: watched(:)
      integer :: i, side, count
      allocate (self%slot(size(system%model%points)))
      self%slot = 0
      count = 0
      do i = 1, size(system%constraints)
         do side = 1, 2
            call enter(system%constraints(i)%item%points(side))
         end do
      end do
      do i = 1, size(self%channels)
         select case (self%channels(i)%kind)
         case (quantity_displacement, quantity_sliding_speed)
            do side = 1, 2
               call enter(system%model%joints(self%channels(i)%of)%points(side))
            end do
         case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum)
         case default; call enter(self%channels(i)%of)
         end select
      end do
      allocate (self%points(count), self%field(3, 0:2, count), self%inertia(3, 0:2, size(watched)))
      do i = 1, size(self%slot)
         if (self%slot(i) > 0) self%points(self%slot(i)) = i
      end do
      self%field = 0.0_wp
      self%inertia = 0.0_wp

   contains

      subroutine enter(point)
         integer, intent(in) :: point
         if (point == 0) return
         if (self%slot(point) > 0 .or. system%model%points(point)%body == ground) return
         if (.not. self%bends(system%model%points(point)%body)) return
         count = count + 1
         self%slot(point) = count
      end subroutine enter

   end subroutine find_slots

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
      self%stuck = .false.
      self%motion = 0.0_wp
      call fill_matrix(self, system, work, q, done)
      if (.not. done) return
      do order = 0, 2
         call follow(self, system, work, q, v, a, order)
         self%most_drawn(order) = max(self%most_drawn(order), maxval(abs(self%field(1:2, order, :))))
      end do
      self%most_drawn(3) = max(self%most_drawn(3), maxval(abs(self%inertia(1:2, 1, :))))
      do i = 1, size(self%channels)
         call observe_channel(self, system, self%channels(i), t, q, v, a)
      end do
   end subroutine observe_drawn_channels

   !> Masses and Jacobians of the bodies that take part, deflections held; with a little softness, so that rows may depend
   !> on others.
   subroutine fill_matrix(self, system, work, q, done)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), contiguous, intent(in) :: q(:)
      logical, intent(out) :: done
      real(wp), parameter :: soft = 1.0e-10_wp, light = 1.0e-12_wp
      real(wp) :: mass(3, 3), own(4), heaviest
      integer :: i, j, m, n, side, first, info
      n = self%motions + self%rows
      self%matrix = 0.0_wp
      do i = 1, size(self%first)
         if (self%first(i) < 0) cycle
         m = system%layout%rates(i)
         first = self%first(i)
         associate (reduced => system%model%bodies(i)%reduced, at => system%layout%q(i))
            if (m == 3) then
               own(1) = reduced%mass
               own(2:3) = centre(system, i, q)
               own(4) = reduced%i0
               call rigid_mass(own, q(at + 2:at + 3), mass)
            else
               mass = 0.0_wp
               mass(1, 1) = reduced%mass
               mass(2, 2) = reduced%mass
            end if
         end associate
         self%matrix(first + 1:first + m, first + 1:first + m) = mass(:m, :m)
      end do
      do i = 1, size(system%constraints)
         if (self%row(i) < 0) cycle
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (.not. takes_part(self, item%bodies(side))) cycle
               first = self%first(item%bodies(side))
               m = system%layout%rates(item%bodies(side))
               do j = 1, item%rows
                  associate (entries => self%matrix(self%motions + self%row(i) + j, first + 1:first + m))
                     entries = entries + work%jacobians(side, i)%z(j, :m)
                  end associate
               end do
            end do
         end associate
      end do
      heaviest = 0.0_wp
      do i = 1, self%motions
         heaviest = max(heaviest, self%matrix(i, i))
      end do
      do i = 1, self%motions
         self%matrix(i, i) = max(self%matrix(i, i), light*heaviest)
         self%scale(i) = 1/sqrt(max(self%matrix(i, i), tiny(1.0_wp)))
      end do
      do i = self%motions + 1, n
         heaviest = 0.0_wp
         do j = 1, self%motions
            heaviest = heaviest + (self%matrix(i, j)*self%scale(j))**2
            self%matrix(j, i) = self%matrix(i, j)
         end do
         self%scale(i) = 1/sqrt(max(heaviest, tiny(1.0_wp)))
      end do
      do i = 1, n
         self%factors(:, i) = self%scale*self%matrix(:, i)*self%scale(i)
         if (i > self%motions) self%factors(i, i) = -soft
      end do
      call dgetrf(n, n, self%factors, n, self%pivots, info)
      done = info == 0
   end subroutine fill_matrix

   !> First moment of mass of a body in its frame (2).
   pure function centre(system, body, q)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), contiguous, intent(in) :: q(:)
      real(wp) :: centre(2)
      associate (reduced => system%model%bodies(body)%reduced, first => system%layout%q(body) + 4)
         centre = reduced%c0
         if (.not. reduced%is_exact) centre = centre_moment(reduced, q(first:first + system%layout%n(body) - 1))
      end associate
   end function centre

   !> How the bodies follow the displacements, or their rates or accelerations: least in the mass norm. A body that
   !> cannot is stuck.
   subroutine follow(self, system, work, q, v, a, order)
      type(drawn_channels_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      integer, intent(in) :: order
      !> Part of the largest gap, or of what is drawn in at most, that joints may leave
      real(wp), parameter :: left = 0.3_wp
      real(wp) :: shift(3), e(3), arm(2), gap, largest, drawn
      integer :: i, j, m, n, side, info
      n = self%motions + self%rows
      self%side = 0.0_wp
      do i = 1, size(self%first)
         if (self%first(i) < 0) cycle
         m = system%layout%rates(i)
         shift = inertia_of(self, system, i, q, v, a, order)
         self%side(self%first(i) + 1:self%first(i) + m) = -shift(:m)
      end do
      do i = 1, size(system%constraints)
         if (self%row(i) < 0) cycle
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%points(side) == 0 .or. .not. takes_part(self, item%bodies(side))) cycle
               e = moved(self, system, item%points(side), q, v, a, order, .false.)
               arm = point_position(system%model, system%layout, system%model%points(item%points(side)), q)
               arm = arm - q(system%layout%q(item%bodies(side)):system%layout%q(item%bodies(side)) + 1)
               do j = 1, item%rows
                  associate (z => work%jacobians(side, i)%z(j, :), row => self%motions + self%row(i) + j)
                     self%side(row) = self%side(row) - dot_product(z(1:2), e(1:2)) - (z(3) - cross(arm, z(1:2)))*e(3)
                  end associate
               end do
            end do
         end associate
      end do
      self%side = self%scale*self%side
      self%factors(:, n + 1) = self%side
      call dgetrs('N', n, 1, self%factors, n, self%pivots, self%factors(:, n + 1), n, info)
      self%motion(:, order) = self%scale(:self%motions)*self%factors(:self%motions, n + 1)
      largest = 0.0_wp
      if (self%rows > 0) largest = maxval(abs(self%side(self%motions + 1:)))
      if (.not. largest > 0.0_wp) return
      drawn = maxval(abs(self%field(1:2, order, :)))
      do i = 1, size(system%constraints)
         if (self%row(i) < 0) cycle
         associate (item => system%constraints(i)%item)
            do j = 1, item%rows
               associate (row => self%motions + self%row(i) + j)
                  gap = self%scale(row)*dot_product(self%matrix(row, :self%motions), self%motion(:, order)) - self%side(row)
                  if (abs(gap) <= left*max(largest, self%scale(row)*drawn)) cycle
               end associate
               do side = 1, 2
                  if (takes_part(self, item%bodies(side))) self%stuck(item%bodies(side)) = .true.
               end do
            end do
         end associate
      end do
   end subroutine follow

   !> Displacement and rotation of a point by the shortening, or their rates or accelerations, along the fixed axes (3): of its body
   !> as it moves, and of the motions that follow.
   function moved(self, system, point, q, v, a, order, whole) result(e)
      type(drawn_channels_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Its index
      integer, intent(in) :: point
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      integer, intent(in) :: order
      !> Whether the motion of this order is in it; else only what those of lower order make
      logical, intent(in) :: whole
      real(wp) :: e(3), arm(2, 0:2), turned(0:2)
      integer :: at, first
      e = 0.0_wp
      associate (own => system%model%points(point))
         if (.not. takes_part(self, own%body)) return
         at = system%layout%q(own%body)
         first = self%first(own%body)
         if (system%layout%rates(own%body) < 3) then
            if (whole) e(1:2) = self%motion(first + 1:first + 2, order)
            return
         end if
         if (self%slot(point) > 0) e = carried(self%field(:, :, self%slot(point)), q(at:), v(at:), a(at:), order)
         arm(:, 0) = point_position(system%model, system%layout, own, q) - q(at:at + 1)
         arm(:, 1) = point_velocity(system%model, system%layout, own, q, v) - v(at:at + 1)
         arm(:, 2) = point_acceleration(system%model, system%layout, own, q, v, a) - a(at:at + 1)
      end associate
      turned = self%motion(first + 3, :)
      if (order == 1) e(1:2) = e(1:2) + turned(0)*turn(arm(:, 1))
      if (order == 2) e(1:2) = e(1:2) + 2*turned(1)*turn(arm(:, 1)) + turned(0)*turn(arm(:, 2))
      if (.not. whole) return
      e(1:2) = e(1:2) + self%motion(first + 1:first + 2, order) + turned(order)*turn(arm(:, 0))
      e(3) = e(3) + turned(order)
   end function moved

   !> A displacement in the axes of a frame that rotates, its rate or acceleration, along the fixed axes; the third number as it is.
   pure function carried(field, q, v, a, order) result(e)
      !> With rate and acceleration (3, 0:2)
      real(wp), intent(in) :: field(3, 0:2)
      !> From the origin of the frame on
      real(wp), intent(in) :: q(4), v(4), a(4)
      integer, intent(in) :: order
      real(wp) :: e(3), part(2), omega, alpha
      omega = cross(q(3:4), v(3:4))
      alpha = cross(q(3:4), a(3:4))
      part = field(1:2, order)
      if (order == 1) part = part + omega*turn(field(1:2, 0))
      if (order == 2) part = part + 2*omega*turn(field(1:2, 1)) + alpha*turn(field(1:2, 0)) - omega**2*field(1:2, 0)
      e(1:2) = along(part, q(3:4))
      e(3) = field(3, order)
   end function carried

   !> The same times the mass of a body, and its moment about the origin (3).
   function inertia_of(self, system, body, q, v, a, order) result(e)
      type(drawn_channels_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      integer, intent(in) :: order
      real(wp) :: e(3), c(2), part(2), omega, alpha
      integer :: at
      e = 0.0_wp
      if (system%layout%rates(body) < 3) return
      at = system%layout%q(body)
      if (self%bends(body)) e = carried(self%inertia(:, :, body), q(at:at + 3), v(at:at + 3), a(at:at + 3), order)
      associate (u => q(at + 2:at + 3), turned => self%motion(self%first(body) + 3, :))
         c = along(centre(system, body, q), u)
         omega = cross(u, v(at + 2:at + 3))
         alpha = cross(u, a(at + 2:at + 3))
         part = 0.0_wp
         if (order == 1) part = -turned(1)*omega*c
         if (order == 2) part = -2*turned(2)*omega*c + turned(1)*(-alpha*c - omega**2*turn(c))
      end associate
      part = system%model%bodies(body)%reduced%mass*part
      e = e + [part, cross(c, part)]
   end function inertia_of

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
         if (any(self%stuck)) return
         e = lacking_momentum(self, system, q, v, a)
         call total_momentum(system, q, v, total)
         lacking = e(1:2)
         shown = total(1:2)
         if (channel%kind == quantity_momentum_y) part = 2
         if (channel%kind == quantity_angular_momentum) then
            lacking = [e(3), 0.0_wp]
            shown = [total(3), 0.0_wp]
         end if
      case (quantity_displacement, quantity_sliding_speed)
         if (any(self%stuck)) return
         associate (joint => system%model%joints(channel%of))
            axis = line_of(system, channel%of, q)
            order = order_of(channel%kind)
            lacking = [dot_product(axis, error_at(joint%points(1), order) - error_at(joint%points(2), order)), 0.0_wp]
            shown = [dot_product(axis, value_at(joint%points(1), order) - value_at(joint%points(2), order)), 0.0_wp]
            if (order == 0) call count_from(shown, [0.0_wp, 0.0_wp])
         end associate
      case default
         associate (point => system%model%points(channel%of))
            if (self%stuck(point%body)) return
            if (channel%body == 0 .and. any(self%stuck)) return
            if (any(channel%kind == [quantity_y, quantity_vy, quantity_ay, quantity_u2])) part = 2
            if (any(channel%kind == [quantity_u1, quantity_u2])) then
               lacking = 0.0_wp
               if (self%slot(channel%of) > 0) lacking = self%field(1:2, 0, self%slot(channel%of))
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
         e = moved(self, system, point, q, v, a, order, .true.)
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

   !> Momentum of the shortening along both axes, and about the fixed origin (3).
   function lacking_momentum(self, system, q, v, a) result(total)
      type(drawn_channels_type), intent(in) :: self
      type(system_type), intent(in) :: system
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      real(wp) :: total(3), e(3)
      integer :: i, k, m, first
      total = 0.0_wp
      do i = 1, size(self%first)
         if (self%first(i) < 0) cycle
         m = system%layout%rates(i)
         first = self%first(i)
         e = inertia_of(self, system, i, q, v, a, 1)
         do k = 1, m
            e(:m) = e(:m) + self%matrix(first + 1:first + m, first + k)*self%motion(first + k, 1)
         end do
         total(1:2) = total(1:2) + e(1:2)
         total(3) = total(3) + e(3) + cross(q(system%layout%q(i):system%layout%q(i) + 1), e(1:2))
      end do
   end function lacking_momentum

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
      ! Not saved: first, bends, motions, rows, row, points, slot, field, inertia, stuck, matrix, factors, scale, side, pivots
   end subroutine exchange_drawn

end module limber_monitor_drawn_channels
