!> Constraints as functions of scalar functions. This one layer makes residual, Jacobian and all derivatives of them; a type of
!> joint supplies f with its first and second derivatives, nothing else. Over a step the derivatives by z are corrected so that they
!> give the change of f exactly, by the least change in a metric of z. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9),
!> (3.14)-(3.16), (3.18)-(3.20); gonzalez1996.
module limber_multibody_function_constraints
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_constraint, only: constraint_type, jacobian_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_markers, only: add_marker, marker_drift, marker_stiffness, marker_column
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_component, function_value, function_weights, &
      & function_ends, function_hessian, hessian_times
   implicit none
   private
   public :: function_constraint_type, linear_type, variables_type, vector_pulls

   !> Most vectors, scalar functions, deflections and equations of a constraint
   integer, parameter, public :: most_vectors = 12, most_functions = 6
   integer, parameter :: most_bends = 24, most_rows = 3
   !> Most variables of f
   integer, parameter :: most_variables = most_functions + most_bends
   !> Most coordinates of both bodies
   integer, parameter :: most_columns = 2*(3 + most_bends)

   !> A constraint of scalar functions
   type, abstract, extends(constraint_type) :: function_constraint_type
      !> Vectors that the scalar functions are of: how many, and which markers
      integer :: vectors = 0, markers(most_vectors) = 0
      !> Scalar functions
      integer :: count = 0
      type(scalar_function_type) :: functions(most_functions)
      !> Index of the deflections that follow them among the variables, in the kinematics; 0: none
      integer :: bend = 0
      !> What moves the first equation, f_1 - s(t): index of the drive; 0: nothing
      integer :: drive = 0
   contains
      !> f and its derivatives
      procedure(function_interface), deferred :: evaluate
      procedure :: residual => constraint_residual
      procedure :: jacobian => constraint_jacobian
      procedure :: stiffness => constraint_stiffness
      procedure :: drift => constraint_drift
      procedure :: gamma => constraint_gamma
      procedure :: rate => constraint_rate
      procedure :: couples => constraint_couples
   end type function_constraint_type

   !> f = coefficients z - offset: joints whose scalar functions say all
   type, extends(function_constraint_type) :: linear_type
      real(wp) :: coefficients(most_rows, most_functions) = 0.0_wp, offset(most_rows) = 0.0_wp
      !> Whether the offset is the value that the sum has where it begins to act
      logical :: keeps = .false.
   contains
      procedure :: evaluate => linear_evaluate
   end type linear_type

   !> f of a constraint at a place, and everything that it is made of
   type :: variables_type
      !> Number of variables, and f of them: value, gradient, second derivatives
      integer :: count = 0
      real(wp) :: z(most_variables), f(most_rows), gradient(most_rows, most_variables)
      real(wp) :: hessian(most_variables, most_variables, most_rows)
   end type variables_type

   abstract interface
      !> f at the variables z: what `order` asks for. What is zero always must be set too.
      pure subroutine function_interface(self, order, at)
         import :: function_constraint_type, variables_type
         class(function_constraint_type), intent(in) :: self
         !> 0: f; 1: also the gradient; 2: also the second derivatives
         integer, intent(in) :: order
         !> z and count on entry
         type(variables_type), intent(inout) :: at
      end subroutine function_interface
   end interface

contains

   pure subroutine linear_evaluate(self, order, at)
      class(linear_type), intent(in) :: self
      integer, intent(in) :: order
      type(variables_type), intent(inout) :: at
      integer :: k
      at%f(:self%rows) = -self%offset(:self%rows)
      do k = 1, at%count
         at%f(:self%rows) = at%f(:self%rows) + self%coefficients(:self%rows, k)*at%z(k)
      end do
      if (order > 0) at%gradient(:self%rows, :at%count) = self%coefficients(:self%rows, :at%count)
      if (order > 1) at%hessian(:at%count, :at%count, :self%rows) = 0.0_wp
   end subroutine linear_evaluate

   pure subroutine constraint_residual(self, kinematics, phi)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
      type(variables_type) :: at
      call find_variables(self, kinematics, at)
      call self%evaluate(0, at)
      if (self%part_of > 0) then
         phi = phi + at%f(:self%rows)
         return
      end if
      phi = at%f(:self%rows)
      if (self%drive > 0) phi(1) = phi(1) - kinematics%drives(self%drive)%value
   end subroutine constraint_residual

   pure subroutine constraint_jacobian(self, kinematics, first, second)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
      type(variables_type) :: at
      real(wp) :: g(2, 3, most_functions), weight(2, most_vectors)
      integer :: row, j, k
      call find_slopes(self, kinematics, 1, g, at)
      first%z = 0.0_wp
      first%eta = 0.0_wp
      second%z = 0.0_wp
      second%eta = 0.0_wp
      do row = 1, self%rows
         call gather_weights(self, at%gradient(row, :self%count), g, weight)
         do j = 1, self%vectors
            if (side_of(self, kinematics, j) == 1) call add_row(kinematics, self%markers(j), weight(:, j), row, first)
            if (side_of(self, kinematics, j) == 2) call add_row(kinematics, self%markers(j), weight(:, j), row, second)
         end do
         do k = self%count + 1, at%count
            second%eta(row, k - self%count) = second%eta(row, k - self%count) + at%gradient(row, k)
         end do
      end do
   end subroutine constraint_jacobian

   pure subroutine constraint_rate(self, kinematics, rate)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      if (self%part_of > 0) return
      rate = 0.0_wp
      if (self%drive > 0) rate(1) = kinematics%drives(self%drive)%rate
   end subroutine constraint_rate

   !> -(d2 f/dY2 Y' Y' + df/dy.bias) + s'', with Y the vectors and deflections: eq. (3.18).
   pure subroutine constraint_gamma(self, kinematics, rate)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      type(variables_type) :: at
      real(wp) :: g(2, 3, most_functions), h(2, 3, 2, 3, most_functions), speed(2, most_vectors), push(2, most_vectors)
      real(wp) :: weight(2, most_vectors), sway(most_bends), bend(most_bends)
      integer :: row, j, k
      call find_slopes(self, kinematics, 2, g, at)
      call find_hessians(self, kinematics, h)
      call find_speeds(self, kinematics, speed, sway)
      do row = 1, self%rows
         call gather_weights(self, at%gradient(row, :self%count), g, weight)
         call turn_weights(self, row, speed, sway, g, h, at, push, bend)
         if (self%part_of == 0) rate(row) = 0.0_wp
         do j = 1, self%vectors
            rate(row) = rate(row) - dot_product(push(:, j), speed(:, j)) &
               & - dot_product(weight(:, j), kinematics%markers(self%markers(j))%bias)
         end do
         do k = 1, at%count - self%count
            rate(row) = rate(row) - bend(k)*sway(k)
         end do
      end do
      if (self%drive > 0) rate(1) = rate(1) + kinematics%drives(self%drive)%acceleration
   end subroutine constraint_gamma

   pure subroutine constraint_drift(self, kinematics, first, second)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
      type(variables_type) :: at
      real(wp) :: g(2, 3, most_functions), h(2, 3, 2, 3, most_functions), speed(2, most_vectors), push(2, most_vectors)
      real(wp) :: weight(2, most_vectors), sway(most_bends), bend(most_bends)
      integer :: row, j, k
      call find_slopes(self, kinematics, 2, g, at)
      call find_hessians(self, kinematics, h)
      call find_speeds(self, kinematics, speed, sway)
      do row = 1, self%rows
         call gather_weights(self, at%gradient(row, :self%count), g, weight)
         call turn_weights(self, row, speed, sway, g, h, at, push, bend)
         do j = 1, self%vectors
            select case (side_of(self, kinematics, j))
            case (1)
               call marker_drift(kinematics, self%markers(j), weight(:, j), first(row, :))
               call add_marker(kinematics%markers(self%markers(j)), push(:, j), first(row, :))
            case (2)
               call marker_drift(kinematics, self%markers(j), weight(:, j), second(row, :))
               call add_marker(kinematics%markers(self%markers(j)), push(:, j), second(row, :))
            end select
         end do
         do k = 1, at%count - self%count
            second(row, 3 + k) = second(row, 3 + k) + bend(k)
         end do
      end do
   end subroutine constraint_drift

   !> J^T (d2 (lambda.f)/dY2) J and what the vectors' own second derivatives make, eq. (3.19).
   pure subroutine constraint_stiffness(self, kinematics, lambda, first, second, across)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
      type(variables_type) :: at
      real(wp) :: g(2, 3, most_functions), h(2, 3, 2, 3, most_functions), push(2, most_vectors)
      real(wp) :: weight(2, most_vectors), bend(most_bends), move(2, most_vectors), change(most_bends), column
      integer :: row, i, j, k, m, n
      call find_slopes(self, kinematics, 2, g, at)
      call find_hessians(self, kinematics, h)
      m = size(first, 1)
      n = size(second, 1)
      do row = 1, self%rows
         call gather_weights(self, at%gradient(row, :self%count), g, weight)
         do j = 1, self%vectors
            if (side_of(self, kinematics, j) == 1) call marker_stiffness(kinematics, self%markers(j), lambda(row)*weight(:, j), &
               & first)
            if (side_of(self, kinematics, j) == 2) call marker_stiffness(kinematics, self%markers(j), lambda(row)*weight(:, j), &
               & second)
         end do
         do j = 1, m + n
            call columns_of(self, kinematics, m, j, move, change)
            call turn_weights(self, row, move, change, g, h, at, push, bend)
            do i = 1, merge(m, m + n, j <= m)
               call columns_of(self, kinematics, m, i, move, change)
               column = 0.0_wp
               do k = 1, self%vectors
                  column = column + dot_product(move(:, k), push(:, k))
               end do
               do k = 1, at%count - self%count
                  column = column + change(k)*bend(k)
               end do
               if (j <= m) then
                  first(i, j) = first(i, j) + lambda(row)*column
               else if (i > m) then
                  second(i - m, j - m) = second(i - m, j - m) + lambda(row)*column
               else
                  across(i, j - m) = across(i, j - m) + lambda(row)*column
               end if
            end do
         end do
      end do
   end subroutine constraint_stiffness

   !> Between two bodies, whatever f is.
   pure logical function constraint_couples(self)
      class(function_constraint_type), intent(in) :: self
      constraint_couples = all(self%bodies /= ground)
   end function constraint_couples

   !> The variables of f at an instant.
   pure subroutine find_variables(self, kinematics, at)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(variables_type), intent(inout) :: at
      integer :: k, n
      at%count = self%count
      do k = 1, self%count
         at%z(k) = function_value(self%functions(k), kinematics)
      end do
      if (self%bend == 0) return
      n = size(kinematics%bends(self%bend)%eta)
      at%z(self%count + 1:self%count + n) = kinematics%bends(self%bend)%eta
      at%count = self%count + n
   end subroutine find_variables

   !> Gradients of the scalar functions, and f with its derivatives up to an order; over a step those of the mean of the
   !> variables, corrected.
   pure subroutine find_slopes(self, kinematics, order, g, at)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: order
      !> Of each function by its own vectors (2, 3, functions)
      real(wp), intent(out) :: g(2, 3, most_functions)
      type(variables_type), intent(inout) :: at
      integer :: k
      do k = 1, self%count
         call function_weights(self%functions(k), kinematics, g(:, :, k))
      end do
      select type (self)
      type is (linear_type)
         ! Its derivatives are the same for all variables
         at%count = self%count
         at%z(:at%count) = 0.0_wp
         call self%evaluate(order, at)
      class default
         if (kinematics%span > 0.0_wp) then
            call correct(self, kinematics, order, at)
         else
            call find_variables(self, kinematics, at)
            call self%evaluate(order, at)
         end if
      end select
   end subroutine find_slopes

   !> Second derivatives of the scalar functions by their own vectors (2, 3, 2, 3, functions).
   pure subroutine find_hessians(self, kinematics, h)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: h(2, 3, 2, 3, most_functions)
      integer :: k
      do k = 1, self%count
         call function_hessian(self%functions(k), kinematics, h(:, :, :, :, k))
      end do
   end subroutine find_hessians

   !> The gradient at the middle of the step's variables, and the least change of it that makes f(z_1) - f(z_0): eq. (3.20).
   pure subroutine correct(self, kinematics, order, at)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: order
      type(variables_type), intent(inout) :: at
      type(variables_type) :: before, after
      real(wp) :: step(most_variables), metric(most_variables), square, missing
      integer :: k, row
      call find_ends(self, kinematics, before, after)
      metric(:self%count) = 1.0_wp
      if (self%bend > 0) metric(self%count + 1:before%count) = kinematics%bends(self%bend)%size**2
      at%count = before%count
      at%z(:at%count) = 0.5_wp*(before%z(:at%count) + after%z(:at%count))
      step(:at%count) = after%z(:at%count) - before%z(:at%count)
      call self%evaluate(order, at)
      call self%evaluate(0, before)
      call self%evaluate(0, after)
      square = 0.0_wp
      do k = 1, at%count
         square = square + metric(k)*step(k)**2
      end do
      if (.not. square > tiny(square)/epsilon(square)) return
      do row = 1, self%rows
         missing = after%f(row) - before%f(row)
         do k = 1, at%count
            missing = missing - at%gradient(row, k)*step(k)
         end do
         do k = 1, at%count
            at%gradient(row, k) = at%gradient(row, k) + missing/square*metric(k)*step(k)
         end do
      end do
   end subroutine correct

   !> The variables of f at the start and the end of a step.
   pure subroutine find_ends(self, kinematics, before, after)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(variables_type), intent(inout) :: before, after
      integer :: k, n
      n = self%count
      do k = 1, n
         call function_ends(self%functions(k), kinematics, before%z(k), after%z(k))
      end do
      if (self%bend > 0) then
         associate (bend => kinematics%bends(self%bend))
            n = self%count + size(bend%eta)
            before%z(self%count + 1:n) = bend%eta - 0.5_wp*kinematics%span*bend%rate
            after%z(self%count + 1:n) = bend%eta + 0.5_wp*kinematics%span*bend%rate
         end associate
      end if
      before%count = n
      after%count = n
   end subroutine find_ends

   !> Derivatives by the vectors from those by the scalar functions.
   pure subroutine gather_weights(self, slope, g, weight)
      class(function_constraint_type), intent(in) :: self
      !> By the scalar functions
      real(wp), intent(in) :: slope(:), g(2, 3, most_functions)
      !> By the vectors (2, vectors)
      real(wp), intent(out) :: weight(2, most_vectors)
      integer :: j, k, v
      weight(:, :self%vectors) = 0.0_wp
      do k = 1, self%count
         do j = 1, 3
            v = self%functions(k)%vectors(j)
            if (v > 0) weight(:, v) = weight(:, v) + slope(k)*g(:, j, k)
         end do
      end do
   end subroutine gather_weights

   !> What a constraint with given multipliers pulls its vectors by: forces on points, and on the ends of directions.
   pure subroutine vector_pulls(self, kinematics, lambda, pull)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> (rows)
      real(wp), intent(in) :: lambda(:)
      !> (2, vectors)
      real(wp), intent(out) :: pull(2, most_vectors)
      type(variables_type) :: at
      real(wp) :: g(2, 3, most_functions), weight(2, most_vectors)
      integer :: row
      call find_slopes(self, kinematics, 1, g, at)
      pull = 0.0_wp
      do row = 1, self%rows
         call gather_weights(self, at%gradient(row, :self%count), g, weight)
         pull(:, :self%vectors) = pull(:, :self%vectors) - lambda(row)*weight(:, :self%vectors)
      end do
   end subroutine vector_pulls

   !> What an equation's derivatives by vectors and deflections change by when these move: d2 f/dY2 applied to a motion.
   pure subroutine turn_weights(self, row, move, change, g, h, at, push, bend)
      class(function_constraint_type), intent(in) :: self
      integer, intent(in) :: row
      !> How vectors and deflections move
      real(wp), intent(in) :: move(2, most_vectors), change(most_bends)
      !> First and second derivatives of each scalar function by its own vectors
      real(wp), intent(in) :: g(2, 3, most_functions), h(2, 3, 2, 3, most_functions)
      type(variables_type), intent(in) :: at
      !> By the vectors, by the deflections
      real(wp), intent(out) :: push(2, most_vectors), bend(most_bends)
      real(wp) :: speed(most_variables), slope(most_variables)
      integer :: i, j, k, v, w
      do k = 1, self%count
         speed(k) = 0.0_wp
         do j = 1, 3
            v = self%functions(k)%vectors(j)
            if (v > 0) speed(k) = speed(k) + dot_product(g(:, j, k), move(:, v))
         end do
      end do
      do k = self%count + 1, at%count
         speed(k) = change(k - self%count)
      end do
      do k = 1, at%count
         slope(k) = 0.0_wp
         do j = 1, at%count
            slope(k) = slope(k) + at%hessian(k, j, row)*speed(j)
         end do
      end do
      call gather_weights(self, slope(:self%count), g, push)
      do k = 1, self%count
         if (self%functions(k)%kind == scalar_component) cycle
         do j = 1, 3
            w = self%functions(k)%vectors(j)
            if (w == 0) cycle
            do i = 1, 3
               v = self%functions(k)%vectors(i)
               if (v > 0) push(:, v) = push(:, v) + at%gradient(row, k)*hessian_times(h(:, :, :, :, k), i, j, move(:, w))
            end do
         end do
      end do
      do k = self%count + 1, at%count
         bend(k - self%count) = slope(k)
      end do
   end subroutine turn_weights

   !> How vectors and deflections move with one coordinate of the two bodies.
   pure subroutine columns_of(self, kinematics, m, j, move, change)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      !> Number of coordinates of the first body; which of all
      integer, intent(in) :: m, j
      real(wp), intent(out) :: move(2, most_vectors), change(most_bends)
      integer :: v, side
      move(:, :self%vectors) = 0.0_wp
      change = 0.0_wp
      do v = 1, self%vectors
         side = side_of(self, kinematics, v)
         if (side == 1 .and. j <= m) move(:, v) = marker_column(kinematics%markers(self%markers(v)), j)
         if (side == 2 .and. j > m) move(:, v) = marker_column(kinematics%markers(self%markers(v)), j - m)
      end do
      if (self%bend > 0 .and. j > m + 3) change(j - m - 3) = 1.0_wp
   end subroutine columns_of

   !> Rates of vectors and deflections.
   pure subroutine find_speeds(self, kinematics, speed, sway)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: speed(2, most_vectors), sway(most_bends)
      integer :: j
      do j = 1, self%vectors
         speed(:, j) = kinematics%markers(self%markers(j))%velocity
      end do
      sway = 0.0_wp
      if (self%bend > 0) sway(:size(kinematics%bends(self%bend)%rate)) = kinematics%bends(self%bend)%rate
   end subroutine find_speeds

   !> Which of the two bodies moves a vector; 0: none.
   pure integer function side_of(self, kinematics, vector) result(side)
      class(function_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: vector
      associate (body => kinematics%markers(self%markers(vector))%body)
         side = 0
         if (body == ground) return
         if (body == self%bodies(2)) side = 2
         if (body == self%bodies(1)) side = 1
      end associate
   end function side_of

   !> Adds to a row of a Jacobian.
   pure subroutine add_row(kinematics, index, weight, row, jacobian)
      type(kinematics_type), intent(in) :: kinematics
      !> Index of the marker
      integer, intent(in) :: index
      real(wp), intent(in) :: weight(2)
      integer, intent(in) :: row
      type(jacobian_type), intent(inout) :: jacobian
      integer :: k
      associate (marker => kinematics%markers(index))
         if (.not. marker%direction) jacobian%z(row, 1:2) = jacobian%z(row, 1:2) + weight
         jacobian%z(row, 3) = jacobian%z(row, 3) + dot_product(weight, marker%lever)
         do k = 1, size(marker%shape, 2)
            jacobian%eta(row, k) = jacobian%eta(row, k) + dot_product(weight, marker%shape(:, k))
         end do
      end associate
   end subroutine add_row

end module limber_multibody_function_constraints
