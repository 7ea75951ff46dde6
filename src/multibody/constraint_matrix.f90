!> Jacobian of all constraints, scaled. The least change of the coordinates that satisfies the constraints, and the combinations of
!> equations that say nothing (the null space of G^T). Small scenes use singular values; large ones the sparse factors of
!>
!>    [ I    G^T  ] [ step ]   [ 0    ]
!>    [ G   -e I  ] [ -mu  ] = [ gaps ]
!>
!> at a cost that is linear in the number of bodies. Floor: multibody. Source: doc/theory, eqs. (4.27), (4.29).
module limber_multibody_constraint_matrix
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgelsd
   use limber_model_model, only: ground
   use limber_multibody_sparse_matrix, only: sparse_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: constraint_matrix_type, new_constraint_matrix, fill, least_step, damped_step, solve_damped
   public :: hold_columns, given_columns, times, transposed_times, full_matrix, small_square

   !> Constraint equations up to which a scene is small
   integer, parameter, public :: small_scene = 120
   !> Damping e of the least step by factors, relative to the square of the largest row
   real(wp), parameter :: small_square = 1.0e-13_wp

   !> The scaled matrix by its entries
   type :: constraint_matrix_type
      !> Whether deflections are among the columns; whether singular values are used
      logical :: flexible = .false., dense = .false.
      integer :: rows = 0, columns = 0
      !> Rate of each column and its scale (columns); scale of each row (rows)
      integer, allocatable :: rate(:)
      real(wp), allocatable :: scale(:), row_scale(:)
      !> The scales of the columns if none is held (columns)
      real(wp), allocatable :: unweighted(:)
      !> Row, column and value of each entry
      integer, allocatable :: row(:), column(:)
      real(wp), allocatable :: value(:)
      !> Relative size below which a combination of equations says nothing. It is far above round-off, for at a singular position
      !> that is met to round-off, 1e-16, combinations are of the order of its root
      real(wp) :: nothing = 1.0e-7_wp
      !> Relative size of singular values that a least step does without
      real(wp) :: truncation = 1.0e-11_wp
      !> Largest norm of a row
      real(wp) :: norm = 0.0_wp
      !> The system above, with the places of the entries in it, as they are and transposed, and of the diagonal
      type(sparse_type) :: matrix
      integer, allocatable, private :: lower(:), upper(:), diagonal(:)
      !> Value of e that is factored; negative: none
      real(wp), private :: factored = -1.0_wp
   end type constraint_matrix_type

contains

   !> Columns and entries.
   subroutine new_constraint_matrix(system, flexible, self, dense)
      type(system_type), intent(in) :: system
      !> Whether the deflections may change too
      logical, intent(in) :: flexible
      type(constraint_matrix_type), intent(inout) :: self
      !> Whether to use singular values; if not given, in small scenes
      logical, intent(in), optional :: dense
      self%flexible = flexible
      self%rows = system%nc
      self%dense = system%nc <= small_scene .and. system%layout%nw <= 3*small_scene
      if (present(dense)) self%dense = dense
      call find_columns(system, self)
      call find_entries(system, self)
   end subroutine new_constraint_matrix

   !> Pattern of the system of the header.
   subroutine analyse_pattern(self)
      type(constraint_matrix_type), intent(inout) :: self
      integer :: i, k
      do k = 1, size(self%row)
         call self%matrix%mark(self%columns + self%row(k), self%column(k))
         call self%matrix%mark(self%column(k), self%columns + self%row(k))
      end do
      call self%matrix%analyse(self%columns + self%rows)
      allocate (self%lower(size(self%row)), self%upper(size(self%row)), self%diagonal(self%columns + self%rows))
      do k = 1, size(self%row)
         self%lower(k) = self%matrix%place(self%columns + self%row(k), self%column(k))
         self%upper(k) = self%matrix%place(self%column(k), self%columns + self%row(k))
      end do
      do i = 1, size(self%diagonal)
         self%diagonal(i) = self%matrix%place(i, i)
      end do
   end subroutine analyse_pattern

   !> Scales: lengths relative to the scene, angles, deflections relative to the scene.
   subroutine find_columns(system, self)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(inout) :: self
      integer :: body, i, k
      allocate (self%rate(system%layout%nw), self%scale(system%layout%nw), self%row_scale(system%nc))
      self%columns = 0
      do body = 1, size(system%layout%q)
         do k = 1, system%layout%rates(body)
            self%columns = self%columns + 1
            self%rate(self%columns) = system%layout%w(body) + k - 1
            self%scale(self%columns) = merge(1.0_wp, system%model%length, k == 3)
         end do
         if (.not. self%flexible) cycle
         do k = 1, system%layout%n(body)
            self%columns = self%columns + 1
            self%rate(self%columns) = system%layout%w(body) + system%layout%rates(body) + k - 1
            self%scale(self%columns) = system%model%length/system%model%bodies(body)%largest_shape
         end do
      end do
      allocate (self%unweighted, source=self%scale)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            self%row_scale(item%first:item%first + item%rows - 1) = item%scale
         end associate
      end do
   end subroutine find_columns

   !> Holds some columns, or none: a least step leaves them as they are, eq. (4.28). `fill` comes behind it.
   pure subroutine hold_columns(self, held)
      type(constraint_matrix_type), intent(inout) :: self
      !> Which (columns)
      logical, intent(in) :: held(:)
      associate (n => size(held))
         self%scale(:n) = merge(0.0_wp, self%unweighted(:n), held)
      end associate
   end subroutine hold_columns

   !> Columns of what the deck gives, in the order in which they are to be kept: angles, then places of bodies.
   pure function given_columns(system, self, rates) result(columns)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(in) :: self
      !> Whether given velocities are meant, else given places
      logical, intent(in) :: rates
      integer, allocatable :: columns(:)
      integer :: body, i, k, n
      logical :: angle(self%columns), place(self%columns)
      angle = .false.
      place = .false.
      i = 0
      do body = 1, size(system%layout%q)
         do k = 1, system%layout%rates(body)
            i = i + 1
            if (.not. system%model%bodies(body)%given(merge(3, 0, rates) + k)) cycle
            angle(i) = k == 3
            place(i) = k < 3
         end do
         n = 0
         if (self%flexible) n = system%layout%n(body)
         i = i + n
      end do
      columns = [pack([(i, i=1, self%columns)], angle), pack([(i, i=1, self%columns)], place)]
   end function given_columns

   !> Rows and columns of the entries, in the order in which `fill` goes through them.
   subroutine find_entries(system, self)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(inout) :: self
      integer :: i, side, body, row, k, count, round
      integer :: first(size(system%layout%q))
      body = 1
      do i = 1, size(first)
         first(i) = body - 1
         body = body + width(system, self, i)
      end do
      do round = 1, 2
         count = 0
         do i = 1, size(system%constraints)
            associate (item => system%constraints(i)%item)
               do side = 1, 2
                  body = item%bodies(side)
                  if (body == ground) cycle
                  if (round == 1) then
                     count = count + item%rows*width(system, self, body)
                     cycle
                  end if
                  do k = 1, width(system, self, body)
                     do row = 1, item%rows
                        count = count + 1
                        self%row(count) = item%first + row - 1
                        self%column(count) = first(body) + k
                     end do
                  end do
               end do
            end associate
         end do
         if (round == 1) allocate (self%row(count), self%column(count), self%value(count))
      end do
   end subroutine find_entries

   !> Number of columns of a body.
   pure integer function width(system, self, body)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(in) :: self
      integer, intent(in) :: body
      width = system%layout%rates(body)
      if (self%flexible) width = width + system%layout%n(body)
   end function width

   !> Values at the Jacobians of the workspace.
   subroutine fill(system, work, self)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(constraint_matrix_type), intent(inout) :: self
      integer :: i, side, body, row, k, count, rates
      real(wp) :: squares(self%rows)
      count = 0
      do i = 1, size(system%constraints)
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground) cycle
            rates = system%layout%rates(body)
            associate (jacobian => work%jacobians(side, i))
               do k = 1, width(system, self, body)
                  do row = 1, system%constraints(i)%item%rows
                     count = count + 1
                     if (k <= rates) then
                        self%value(count) = jacobian%z(row, k)
                     else
                        self%value(count) = jacobian%eta(row, k - rates)
                     end if
                  end do
               end do
            end associate
         end do
      end do
      squares = 0.0_wp
      do k = 1, size(self%value)
         self%value(k) = self%value(k)*self%scale(self%column(k))/self%row_scale(self%row(k))
         squares(self%row(k)) = squares(self%row(k)) + self%value(k)**2
      end do
      self%norm = 0.0_wp
      if (size(squares) > 0) self%norm = sqrt(maxval(squares))
      self%factored = -1.0_wp
   end subroutine fill

   !> G vector (rows).
   pure function times(self, vector) result(product)
      type(constraint_matrix_type), intent(in) :: self
      !> Scaled (columns)
      real(wp), intent(in) :: vector(:)
      real(wp), allocatable :: product(:)
      integer :: k
      allocate (product(self%rows))
      product = 0.0_wp
      do k = 1, size(self%value)
         product(self%row(k)) = product(self%row(k)) + self%value(k)*vector(self%column(k))
      end do
   end function times

   !> G^T vector (columns).
   pure function transposed_times(self, vector) result(product)
      type(constraint_matrix_type), intent(in) :: self
      !> Scaled (rows)
      real(wp), intent(in) :: vector(:)
      real(wp), allocatable :: product(:)
      integer :: k
      allocate (product(self%columns))
      product = 0.0_wp
      do k = 1, size(self%value)
         product(self%column(k)) = product(self%column(k)) + self%value(k)*vector(self%row(k))
      end do
   end function transposed_times

   !> The matrix with all its zeros (rows, columns).
   pure function full_matrix(self) result(full)
      type(constraint_matrix_type), intent(in) :: self
      real(wp), allocatable :: full(:, :)
      integer :: k
      allocate (full(self%rows, self%columns))
      full = 0.0_wp
      do k = 1, size(self%value)
         full(self%row(k), self%column(k)) = full(self%row(k), self%column(k)) + self%value(k)
      end do
   end function full_matrix

   !> The change of least norm that satisfies the equations, or where they contradict each other comes nearest to that: eq. (4.27).
   subroutine least_step(self, gaps, step)
      type(constraint_matrix_type), intent(inout) :: self
      !> Right-hand sides (rows)
      real(wp), intent(in) :: gaps(:)
      !> Changes in the layout of the rates (nw)
      real(wp), intent(out) :: step(:)
      real(wp), allocatable :: matrix(:, :), unknown(:, :), values(:), buffer(:)
      integer, allocatable :: integers(:)
      integer :: m, n, info, rank
      if (.not. self%dense) then
         call damped_step(self, gaps, small_square*self%norm**2, step)
         return
      end if
      m = self%rows
      n = self%columns
      allocate (matrix, source=full_matrix(self))
      allocate (unknown(max(m, n), 1), values(min(m, n)), buffer(20*(m + n)**2 + 2000), integers(100*(m + n) + 100))
      unknown = 0.0_wp
      unknown(:m, 1) = gaps/self%row_scale
      call dgelsd(m, n, 1, matrix, m, unknown, max(m, n), values, self%truncation, rank, buffer, size(buffer), integers, info)
      step = 0.0_wp
      if (info /= 0) return
      step(self%rate(:n)) = unknown(:n, 1)*self%scale(:n)
   end subroutine least_step

   !> The change that makes |change|^2 + |equations left open|^2/e least: with a large e a short one, that never goes the wrong way.
   subroutine damped_step(self, gaps, e, step)
      type(constraint_matrix_type), intent(inout) :: self
      real(wp), intent(in) :: gaps(:)
      !> Damping [scaled rows, squared]
      real(wp), intent(in) :: e
      !> As in `least_step`
      real(wp), intent(out) :: step(:)
      real(wp) :: unknown(self%columns + self%rows)
      unknown(:self%columns) = 0.0_wp
      unknown(self%columns + 1:) = gaps/self%row_scale
      call solve_damped(self, e, unknown)
      step = 0.0_wp
      step(self%rate(:self%columns)) = unknown(:self%columns)*self%scale(:self%columns)
   end subroutine damped_step

   !> Solves the system of the header; factors are made anew when the values or e have changed.
   subroutine solve_damped(self, e, unknown)
      type(constraint_matrix_type), intent(inout) :: self
      !> As in `damped_step`
      real(wp), intent(in) :: e
      !> Right-hand side, then solution (columns + rows)
      real(wp), contiguous, intent(inout) :: unknown(:)
      logical :: singular
      integer :: k
      if (.not. allocated(self%diagonal)) call analyse_pattern(self)
      if (.not. abs(self%factored - e) <= 0.0_wp) then
         self%matrix%values = 0.0_wp
         self%matrix%values(self%diagonal(:self%columns)) = 1.0_wp
         self%matrix%values(self%diagonal(self%columns + 1:)) = -e
         do k = 1, size(self%value)
            self%matrix%values(self%lower(k)) = self%matrix%values(self%lower(k)) + self%value(k)
            self%matrix%values(self%upper(k)) = self%matrix%values(self%upper(k)) + self%value(k)
         end do
         call self%matrix%factor(singular)
         self%factored = e
      end if
      call self%matrix%solve(unknown)
   end subroutine solve_damped

end module limber_multibody_constraint_matrix
